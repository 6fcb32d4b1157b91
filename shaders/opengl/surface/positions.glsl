// The mesh as it lies now, in the units that it was given in.
layout(binding = UNIT_MESH_POSITIONS) uniform samplerBuffer mesh_positions;

vec3 mesh_position(int vertex) { return texelFetch(mesh_positions, vertex).xyz; }
