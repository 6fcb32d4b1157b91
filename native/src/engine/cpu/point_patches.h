// Half-edges → the order in which exact sums visit a mesh: groups of up to sixteen points that are evaluated together, patches of
// up to eight points, and the triangles of each patch.
//
// The order depends on connectivity only. All indices are in this order, except the values of `point` and `triangle`.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"

namespace paradesc {

struct PointPatches {
  static constexpr int32_t most_points = 8; // per patch
  static constexpr int32_t near_neighbors = 8;

  std::vector<int32_t> point;          // index in the mesh
  std::vector<int32_t> group_begin;    // (groups + 1) into point
  std::vector<int32_t> patch_begin;    // (patches + 1) into point
  std::vector<int32_t> triangle_begin; // (patches + 1) into triangle
  std::vector<int32_t> triangle;       // index in the mesh; patch of two of its corners, or the middle one of three
  std::vector<int32_t> corner;         // (3 * triangles) points; then padding
  std::vector<int32_t> twin;           // (3 * triangles) the half-edge across, 3 * triangle + k; -1: boundary
  std::vector<int32_t> neighbor;       // (points, near_neighbors) adjacent points; points() marks an unused entry
  std::vector<int32_t> more_begin;     // (points + 1) into more
  std::vector<int32_t> more;           // further neighbors of points with more than near_neighbors
  std::vector<int32_t> link_begin;     // (patches + 1) into link
  std::vector<int32_t> link;           // adjacent patches
  std::vector<int32_t> edge_begin;     // (patches + 1) into edge
  std::vector<int32_t> edge;           // boundary half-edges of the patch's triangles
  std::vector<int32_t> patch_of;       // (points)

  int32_t points() const { return static_cast<int32_t>(point.size()); }
  int32_t groups() const { return static_cast<int32_t>(group_begin.size()) - 1; }
  int32_t patches() const { return static_cast<int32_t>(patch_begin.size()) - 1; }
};

PointPatches build_point_patches(const HalfEdges &half_edges);

} // namespace paradesc
