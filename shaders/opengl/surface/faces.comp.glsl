#version 450 core
// One invocation, one triangle → its unit normal.
#include "device.glsl"
#include "shared.h"
#include "opengl/surface/mesh.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_FACES) writeonly restrict buffer Faces { vec4 faces[]; };
layout(location = LOCATION_FIRST) uniform int first;
layout(location = LOCATION_LAST) uniform int last;

dvec3 corner_of(int triangle, int corner) { return mesh_position(texelFetch(triangle_vertices, 3 * triangle + corner).x); }

void main() {
  int triangle = first + int(gl_GlobalInvocationID.x);
  if (triangle >= last) return;
  dvec3 origin = corner_of(triangle, 0);
  faces[triangle] = vec4(vec3(unit_or_zero(cross(corner_of(triangle, 1) - origin, corner_of(triangle, 2) - origin))), 0.0);
}
