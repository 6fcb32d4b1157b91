#version 450 core
// One invocation per triangle → its unit normal, or zero.
#include "paper/elements.glsl"
#include "paper/surface/mesh.glsl"
layout(binding = UNIT_TRIANGLES) uniform isamplerBuffer triangle_vertices;
layout(std430, binding = BINDING_FACES) writeonly restrict buffer Faces { vec4 faces[]; };

void main() {
  int triangle = own_element();
  if (triangle >= last) return;
  ivec3 corners = texelFetch(triangle_vertices, triangle).xyz;
  dvec3 a = dvec3(mesh_position(corners.x)), b = dvec3(mesh_position(corners.y)), c = dvec3(mesh_position(corners.z));
  dvec3 product = cross(b - a, c - a);
  double size = sqrt(dot(product, product));
  faces[triangle] = vec4(vec3(size > 0.0LF ? product / size : dvec3(0.0LF)), 0.0);
}
