// Chart borders → the texel grid that marches read, with seam_links the paper's adjacency buffer (section 3.3): which border
// edges pass through each texel, and how far a texel is from the nearest of them. Depends on the layout alone, so it is made once
// per topology and buffer size.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/charts.h"

namespace paradesc {

struct BorderGrid {
  int size = 0;                // texels along a side
  std::vector<int32_t> cells;  // (size * size, 2): texels that a march may skip from anywhere in this one, or 0, or -number of
                               // edges in it; first entry in `list`
  std::vector<int32_t> list;   // (entries, 2): border, its chart
  std::vector<vec4> border_uv; // (borders) u0, v0, u1, v1, the chart on the left
};

BorderGrid build_border_grid(const Charts &charts, int size);

// (borders) the number of each border's seam as seen from its side: consecutive borders whose twins are consecutive, too, form
// one seam. -1 if there is no other side.
std::vector<int32_t> number_seams(const Charts &charts);

} // namespace paradesc
