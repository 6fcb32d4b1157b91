// The current mesh, in the caller's units.
layout(binding = UNIT_MESH_POSITIONS) uniform samplerBuffer mesh_positions;

vec3 mesh_position(int vertex) { return texelFetch(mesh_positions, vertex).xyz; }
