#version 450 core
// One invocation per list of centers that lie together → the cells near any of them, in the order of cells.
//
// Some of these cells may not be connected to the centers; near.comp.glsl detects when that is possible.
#include "opengl/elements.glsl"
#include "opengl/cells/search.glsl"
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_FOUND_CELLS) writeonly restrict buffer FoundCells { int found_cells[]; };
layout(std430, binding = BINDING_NEAR_RANGES) writeonly restrict buffer NearRanges { ivec4 near_ranges[]; };
layout(std430, binding = BINDING_NEAR_BALLS) writeonly restrict buffer NearBalls { vec4 near_balls[]; };
layout(binding = UNIT_START_LISTS) uniform isamplerBuffer start_lists;
layout(binding = UNIT_CELL_NODES) uniform isamplerBuffer nodes;
layout(location = LOCATION_NODES) uniform int node_count;

void main() {
  int list = own_element();
  if (list >= last) return;
  ivec2 range = texelFetch(start_lists, list).xy;
  vec3 low = vec3(1e30), high = vec3(-1e30);
  for (int i = range.x; i < range.y; ++i) {
    low = min(low, centers[i].position);
    high = max(high, centers[i].position);
  }
  vec3 middle = 0.5 * (low + high);
  float reach = search.radius + 0.5 * length(high - low), square = reach * reach;
  int count = 0, room = search.room.longest;
  int node = 0;
  for (int turn = 0; node < node_count && turn < MAX_ITERATIONS; ++turn) {
    ivec4 from = texelFetch(nodes, 2 * node), to = texelFetch(nodes, 2 * node + 1);
    vec3 low_gap = intBitsToFloat(from.xyz) - middle, high_gap = intBitsToFloat(to.xyz) - middle;
    vec3 gap = max(max(low_gap, -high_gap), 0.0), far = low_gap + high_gap;
    float limit = 2.0 * reach + high_gap.x - low_gap.x;
    bool is_cell = to.w >= 0, meets = is_cell ? dot(far, far) < limit * limit : dot(gap, gap) < square; // its box is around a ball
    if (meets && is_cell) {
      if (count < room) found_cells[list * room + count] = to.w;
      ++count;
    }
    node = meets ? node + 1 : from.w;
  }
  int first = atomicAdd(counts.cells, count);
  atomicMax(counts.longest, node < node_count ? MAX_ITERATIONS : count); // more cells than a device may visit
  near_ranges[list] = ivec4(first, first + count, 0, 0);
  near_balls[list] = vec4(middle, reach);
}
