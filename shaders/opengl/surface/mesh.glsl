// The current mesh, its triangles, and vectors in doubles.
#include "opengl/surface/positions.glsl"
layout(binding = UNIT_TRIANGLES) uniform isamplerBuffer triangle_vertices;

// The unit vector along v, or zero.
dvec3 unit_or_zero(dvec3 v) {
  double size = sqrt(dot(v, v));
  return size > 0.0LF ? v / size : dvec3(0.0LF);
}
