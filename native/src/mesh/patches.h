// Half-edges → connected patches of a few triangles each: what is looked at as a whole where triangles are many.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"
#include "support/math.h"

namespace paradesc {

// Depends on how the mesh hangs together alone, not on positions. A triangle's code is its patch times max_triangles, and its
// place there: a bit of one word.
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
