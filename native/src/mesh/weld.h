// Vertices → places: vertices at one position, as exporters split them, are one place of the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/triangles.h"

namespace paradesc {

struct Places {
  std::vector<int32_t> of_vertex; // (vertex_count) the first vertex at the same place
  std::vector<int32_t> of_corner; // (3 * triangle_count) the place of its vertex; empty where no two vertices share a place

  bool are_shared() const { return !of_corner.empty(); }
  // Ids per corner that tell places apart.
  const std::vector<int32_t> &ids(const Triangles &triangles) const { return are_shared() ? of_corner : triangles.corner_vertex; }
};

// Places by equal positions.
Places weld(const Triangles &triangles);

// Merges places at the ends of open half-edges that differ only by rounding: by 16 units in the last place of a float at the
// largest coordinate among them (about the seventh decimal digit), and by at most a hundredth of the shortest edge at either
// place, so that no edge shrinks to nothing. A closed surface stays as it is. Returns whether any were merged. left_out:
// (triangle_count) 1 where a triangle takes no part.
bool weld_rims(const Triangles &triangles, const std::vector<uint8_t> &left_out, std::span<const int32_t> open, Places &places);

} // namespace paradesc
