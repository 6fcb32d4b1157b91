// The mesh as it lies now, in the units that it was given in.
layout(binding = UNIT_MESH_POSITIONS) uniform samplerBuffer mesh_positions;
layout(binding = UNIT_TRIANGLES) uniform isamplerBuffer triangle_vertices;

dvec3 mesh_position(int vertex) {
  return dvec3(texelFetch(mesh_positions, 3 * vertex).x, texelFetch(mesh_positions, 3 * vertex + 1).x,
               texelFetch(mesh_positions, 3 * vertex + 2).x);
}

// Unit, or zero.
dvec3 unit_or_zero(dvec3 v) {
  double size = sqrt(dot(v, v));
  return size > 0.0LF ? v / size : dvec3(0.0LF);
}
