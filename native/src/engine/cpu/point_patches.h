// Half-edges → the order in which exact sums see a mesh: points in groups of up to sixteen that are evaluated together, patches
// of up to eight of them, and the triangles of each patch.
//
// It depends on how the mesh hangs together alone. All indices but those in point and in triangle are places in this order.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"

namespace paradesc {

struct PointPatches {
  static constexpr int32_t most_points = 8; // of a patch
  static constexpr int32_t near_neighbors = 8;

  std::vector<int32_t> point;          // of the mesh
  std::vector<int32_t> group_begin;    // (groups + 1) into point
  std::vector<int32_t> patch_begin;    // (patches + 1) likewise
  std::vector<int32_t> triangle_begin; // (patches + 1) into triangle
  std::vector<int32_t> triangle;       // of the mesh: of the patch that has two of its corners, or else its middle one
  std::vector<int32_t> corner;         // (3 * triangles) points; then some that are read, but not used
  std::vector<int32_t> twin;           // (3 * triangles) the half-edge across, 3 * triangle + k; -1: boundary
  std::vector<int32_t> neighbor;       // (points, near_neighbors) points over an edge; points(): no more
  std::vector<int32_t> more_begin;     // (points + 1) into more
  std::vector<int32_t> more;           // neighbors for which there is no room above
  std::vector<int32_t> link_begin;     // (patches + 1) into link
  std::vector<int32_t> link;           // patches of neighbors
  std::vector<int32_t> edge_begin;     // (patches + 1) into edge
  std::vector<int32_t> edge;           // half-edges of the patch's triangles on the mesh's boundary
  std::vector<int32_t> patch_of;       // (points)

  int32_t points() const { return static_cast<int32_t>(point.size()); }
  int32_t groups() const { return static_cast<int32_t>(group_begin.size()) - 1; }
  int32_t patches() const { return static_cast<int32_t>(patch_begin.size()) - 1; }
};

PointPatches build_point_patches(const HalfEdges &half_edges);

} // namespace paradesc
