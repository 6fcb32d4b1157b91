// Half-edges → connected patches of a few triangles each, which are handled as a whole where there are many triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"
#include "support/math.h"

namespace paradesc {

// Patches depend on connectivity alone, not on positions. A triangle's code is patch * max_triangles + its place in the patch;
// this place is the number of a bit in one word.
struct Patches {
  static constexpr int32_t max_triangles = 32;

  std::vector<int32_t> code;           // (triangle_count) -1: left out
  std::vector<int32_t> triangle;       // (patches, max_triangles) by code; -1: none
  std::vector<int32_t> neighbor_begin; // (patches + 1) into neighbor
  std::vector<ivec2> neighbor;         // another patch, and the bits of its triangles that share an edge with this one

  int32_t count() const { return static_cast<int32_t>(triangle.size()) / max_triangles; }
  // The code of the triangle across a half-edge, or -1.
  int32_t across(const HalfEdges &half_edges, int32_t half_edge) const {
    const int32_t twin = half_edges.twin[half_edge];
    return twin < 0 ? -1 : code[twin / 3];
  }
};

Patches build_patches(const HalfEdges &half_edges);

} // namespace paradesc
