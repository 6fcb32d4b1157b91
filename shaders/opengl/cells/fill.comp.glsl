#version 450 core
// One invocation per list of near cells → its cells in the common array, the places of their neighbors, and their mean normal.
#include "opengl/elements.glsl"
#include "opengl/cells/search.glsl"
layout(std430, binding = BINDING_FOUND_CELLS) readonly restrict buffer FoundCells { int found_cells[]; };
layout(std430, binding = BINDING_NEAR_CELLS) writeonly restrict buffer NearCells { int near_cells[]; };
layout(std430, binding = BINDING_NEAR_LISTS) writeonly restrict buffer NearLists { ivec2 near_lists[]; };
layout(std430, binding = BINDING_NEAR_RANGES) restrict buffer NearRanges { ivec4 near_ranges[]; };
layout(std430, binding = BINDING_NEAR_NORMALS) writeonly restrict buffer NearNormals { vec4 near_normals[]; };
layout(binding = UNIT_CELL_LISTS) uniform isamplerBuffer cell_lists;
layout(binding = UNIT_CELL_TRAITS) uniform isamplerBuffer cell_traits;

void main() {
  int list = own_element();
  if (list >= last || !cells_fit()) return; // all neighbors are counted, with or without room
  ivec4 range = near_ranges[list];
  int neighbors = 0;
  vec3 sum = vec3(0.0);
  for (int i = 0; i < range.y - range.x; ++i) {
    int cell = found_cells[list * search.room.longest + i];
    near_cells[range.x + i] = cell;
    near_lists[range.x + i] = ivec2(list, neighbors);
    ivec2 adjacent = texelFetch(cell_lists, cell).xy;
    neighbors += adjacent.y - adjacent.x;
    float area = intBitsToFloat(texelFetch(cell_traits, CELL_TRAITS * cell + 2).x);
    sum += intBitsToFloat(texelFetch(cell_traits, CELL_TRAITS * cell + 1).xyz) * area;
  }
  near_ranges[list].z = atomicAdd(counts.neighbors, neighbors);
  float size = length(sum);
  near_normals[list] = vec4(size > 0.0 ? sum / size : vec3(0.0), 0.0);
}
