#version 450 core
// One invocation per triangle → its unit normal, and the root of twice its area.
#include "opengl/elements.glsl"
#include "opengl/surface/mesh.glsl"
layout(std430, binding = BINDING_FACES) writeonly restrict buffer Faces { vec4 faces[]; };

void main() {
  int triangle = own_element();
  if (triangle >= last) return;
  ivec3 corners = texelFetch(triangle_vertices, triangle).xyz;
  dvec3 a = dvec3(mesh_position(corners.x)), b = dvec3(mesh_position(corners.y)), c = dvec3(mesh_position(corners.z));
  dvec3 product = cross(b - a, c - a);
  faces[triangle] = vec4(vec3(unit_or_zero(product)), float(sqrt(sqrt(dot(product, product)))));
}
