// Chart borders → the texel grid that a sample's march reads: which border edges pass through each texel, and how far a texel is from
// the nearest of them. Depends on the layout alone, so it is made once per topology and buffer size.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/charts.h"
#include "mesh/triangles.h"

namespace paradesc {

struct BorderGrid {
  int size = 0;                 // texels along a side
  std::vector<int32_t> cells;   // (size * size, 2): texels that a march may skip from anywhere in this one, or 0, or -number of edges
                                // in it; first entry in `list`
  std::vector<int32_t> list;    // (entries, 2): border, its chart
  std::vector<vec4> border_uv;  // (borders) u0, v0, u1, v1, the chart on the left
};

BorderGrid build_border_grid(const Triangles &triangles, const Charts &charts, int size);

// Texels from this place to the nearest border, at least.
inline int clearance(const BorderGrid &grid, vec2 uv) {
  const auto texel = [&](float x) { return glm::clamp(static_cast<int>(x * static_cast<float>(grid.size)), 0, grid.size - 1); };
  return glm::max(grid.cells[2 * (static_cast<size_t>(texel(uv.y)) * static_cast<size_t>(grid.size) + static_cast<size_t>(texel(uv.x)))], 0);
}

} // namespace paradesc
