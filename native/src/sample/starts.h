// Centers → the cells that their searches start from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "support/math.h"

namespace paradesc {

// Centers by the first cell that each starts from, which is the one that it belongs to; those that start nowhere come last.
struct Starts {
  std::vector<int32_t> order; // (centers) as they were given
  std::vector<ivec2> range;   // (centers) first and end in cell
  std::vector<ivec2> cell;    // and, of a center's first one, the center's list
  std::vector<ivec2> list;    // first and end of centers of one cell: what is near them is looked for once
};

// begin: (centers + 1) into the cells that each center starts from.
Starts list_starts(std::span<const int32_t> begin, std::span<const int32_t> start_cells, int cell_count);

} // namespace paradesc
