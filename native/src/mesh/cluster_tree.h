// Half-edges → a tree of connected clusters of triangles, or of points: pairs of neighbors, pairs of pairs, and so on.
//
// The tree depends on connectivity alone, not on positions: every frame of an animation has the same tree, whichever frame came
// first.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"

namespace paradesc {

// Level 0 has one cluster for each point. The clusters of a level stand in the order of these items, so that each cluster is a
// range of every level below it.
struct ClusterTree {
  static constexpr size_t max_children = 3;
  std::vector<int32_t> item;                     // the points of level 0
  std::vector<int32_t> rank;                     // (point_count) the index of each in there
  std::vector<std::vector<int32_t>> child_begin; // [level - 1](clusters + 1) into the level below

  size_t levels() const { return child_begin.size() + 1; }
  size_t size(size_t level) const { return level == 0 ? item.size() : child_begin[level - 1].size() - 1; }
};

// The points that share an edge with each.
struct PointNeighbors {
  std::vector<int32_t> begin{0}; // (point_count + 1) into neighbor
  std::vector<int32_t> neighbor;
};
PointNeighbors find_point_neighbors(const HalfEdges &half_edges);
ClusterTree build_point_tree(const PointNeighbors &neighbors);

} // namespace paradesc
