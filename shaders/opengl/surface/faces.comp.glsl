#version 450 core
// One invocation, one triangle → its unit normal.
#include "opengl/elements.glsl"
#include "opengl/surface/mesh.glsl"
layout(std430, binding = BINDING_FACES) writeonly restrict buffer Faces { vec4 faces[]; };

dvec3 corner_of(int triangle, int corner) { return mesh_position(texelFetch(triangle_vertices, 3 * triangle + corner).x); }

void main() {
  int triangle = own_element();
  if (triangle >= last) return;
  dvec3 origin = corner_of(triangle, 0);
  faces[triangle] = vec4(vec3(unit_or_zero(cross(corner_of(triangle, 1) - origin, corner_of(triangle, 2) - origin))), 0.0);
}
