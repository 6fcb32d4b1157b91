// Centers → the cells that their searches start from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "support/math.h"

namespace paradesc {

// Centers sorted by the cell that they belong to, the first one that each starts from. Centers without a start cell come last.
struct Starts {
  std::vector<int32_t> order; // (centers) index of each center before sorting
  std::vector<ivec2> range;   // (centers) first and end in cell
  std::vector<ivec2> cell;    // a start cell; for a center's first one, also the center's list
  std::vector<ivec2> list;    // first and end of centers of one cell, which share one search for near cells
};

// begin: (centers + 1) offsets into start_cells, which lists the cells that each center starts from.
Starts list_starts(std::span<const int32_t> begin, std::span<const int32_t> start_cells, int cell_count);

} // namespace paradesc
