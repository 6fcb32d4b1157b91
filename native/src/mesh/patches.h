// Half-edges → connected patches of a few triangles each: what is looked at as a whole where triangles are many.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"

namespace paradesc {

// Depends on how the mesh hangs together alone, not on positions.
struct Patches {
  static constexpr size_t max_triangles = 28;

  std::vector<int32_t> triangle_patch; // (triangle_count) -1: left out
  std::vector<int32_t> begin;          // (patches + 1) into triangle
  std::vector<int32_t> triangle;       // of each patch, connected
  std::vector<uint8_t> corner;         // (3 * triangles) the index of each corner in the patch's list of points
  std::vector<int32_t> point_begin;    // (patches + 1) into point
  std::vector<int32_t> point;          // of each patch
  std::vector<int32_t> link_begin;     // (patches' points + 1) into link
  std::vector<int32_t> link;           // the other patches that have the point too

  size_t count() const { return begin.empty() ? 0 : begin.size() - 1; }
};

Patches build_patches(const HalfEdges &half_edges);

} // namespace paradesc
