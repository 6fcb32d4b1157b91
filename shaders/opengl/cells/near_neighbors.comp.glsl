#version 450 core
// One work group per list of near cells → the neighbors of each of its cells within the list, for centers that follow links.
#include "device.glsl"
#include "shared.h"
#include "opengl/cells/near_list.glsl"
#include "opengl/cells/walks.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_NEAR_NEIGHBORS) writeonly restrict buffer Neighbors { ivec4 near_neighbors[]; };
layout(binding = UNIT_CELL_LISTS) uniform isamplerBuffer cell_lists;
layout(binding = UNIT_NEAR_LISTS) uniform isamplerBuffer near_lists;
layout(binding = UNIT_NEAR_RANGES) uniform isamplerBuffer near_ranges;
layout(binding = UNIT_ADJACENCY) uniform isamplerBuffer adjacency;
layout(binding = UNIT_CELL_LINKS) uniform isamplerBuffer cell_links;

void main() {
  for (int i = int(gl_WorkGroupID.x); i < walks[WALKS_LISTS]; i += int(gl_NumWorkGroups.x)) {
    ivec4 list = texelFetch(near_ranges, walks[walks_list(i)]);
    ivec2 range = list.xy;
    for (int entry = range.x + int(gl_LocalInvocationID.x); entry < range.y; entry += GROUP_SIZE) {
      int cell = texelFetch(near_list, entry).x, first = list.z + texelFetch(near_lists, entry).y;
      ivec2 neighbors = texelFetch(cell_lists, cell).xy;
      for (int k = neighbors.x; k < neighbors.y; ++k) {
        ivec2 neighbor = texelFetch(adjacency, k).xy;
        near_neighbors[first + k - neighbors.x] =
            ivec4(place_of(neighbor.x, range), neighbor.y, texelFetch(cell_links, neighbor.y).xy);
      }
    }
  }
}
