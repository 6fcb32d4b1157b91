// Cuts the tree of points into small clusters, and then collects the adjacency of points and patches.
#include "engine/cpu/point_patches.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "engine/cpu/ball_sums.h"
#include "mesh/cluster_tree.h"
#include "support/cancel.h"

namespace paradesc {

// Returns where the largest clusters with at most so many items begin, as indices in the tree's order, followed by its end.
static std::vector<int32_t> cut_tree(const ClusterTree &tree, int32_t most) {
  std::vector<int32_t> begins;
  std::vector<int32_t> places; // (clusters of the level + 1) in the tree's order
  std::vector<std::vector<int32_t>> by_level(tree.levels());
  places.resize(tree.size(0) + 1);
  std::iota(places.begin(), places.end(), 0);
  by_level[0] = places;
  for (size_t level = 1; level < tree.levels(); ++level) {
    checkpoint();
    for (const int32_t child : tree.child_begin[level - 1]) by_level[level].push_back(by_level[level - 1][child]);
  }
  const auto cut = [&](const auto &self, size_t level, size_t cluster) -> void {
    const int32_t begin = by_level[level][cluster], end = by_level[level][cluster + 1];
    if (level == 0 || end - begin <= most) return begins.push_back(begin);
    const std::vector<int32_t> &children = tree.child_begin[level - 1];
    for (int32_t child = children[cluster]; child < children[cluster + 1]; ++child)
      self(self, level - 1, static_cast<size_t>(child));
  };
  for (size_t cluster = 0; cluster < tree.size(tree.levels() - 1); ++cluster) cut(cut, tree.levels() - 1, cluster);
  begins.push_back(static_cast<int32_t>(tree.size(0)));
  return begins;
}

// Lists the triangles of each patch in the order of the mesh.
static void place_triangles(const HalfEdges &half_edges, const std::vector<int32_t> &rank, PointPatches &patches) {
  const size_t count = half_edges.corner_point.size() / 3;
  std::vector<int32_t> owner(count, -1), place(count, -1);
  patches.triangle_begin.assign(static_cast<size_t>(patches.patches()) + 1, 0);
  for (size_t t = 0; t < count; ++t) {
    checkpoint_at(t);
    if (half_edges.corner_point[3 * t] < 0) continue;
    std::array<int32_t, 3> of_corner;
    for (size_t k = 0; k < 3; ++k) of_corner[k] = patches.patch_of[rank[half_edges.corner_point[3 * t + k]]];
    std::ranges::sort(of_corner);
    owner[t] = of_corner[1];
    ++patches.triangle_begin[of_corner[1] + 1];
  }
  std::partial_sum(patches.triangle_begin.begin(), patches.triangle_begin.end(), patches.triangle_begin.begin());
  patches.triangle.resize(static_cast<size_t>(patches.triangle_begin.back()));
  std::vector<int32_t> next(patches.triangle_begin.begin(), patches.triangle_begin.end() - 1);
  for (size_t t = 0; t < count; ++t) {
    checkpoint_at(t);
    if (owner[t] < 0) continue;
    place[t] = next[owner[t]]++;
    patches.triangle[place[t]] = static_cast<int32_t>(t);
  }
  patches.corner.reserve(3 * (patches.triangle.size() + group_lanes));
  patches.twin.reserve(3 * patches.triangle.size());
  for (const int32_t t : patches.triangle) {
    checkpoint_at(patches.twin.size());
    for (int32_t half_edge = 3 * t; half_edge < 3 * t + 3; ++half_edge) {
      const int32_t twin = half_edges.twin[half_edge];
      patches.corner.push_back(rank[half_edges.corner_point[half_edge]]);
      patches.twin.push_back(twin < 0 ? -1 : 3 * place[twin / 3] + twin % 3);
    }
  }
  patches.corner.resize(3 * (patches.triangle.size() + group_lanes), 0);
}

static void place_neighbors(const PointNeighbors &neighbors, const std::vector<int32_t> &rank, PointPatches &patches) {
  constexpr auto room = static_cast<size_t>(PointPatches::near_neighbors);
  patches.neighbor.assign(room * patches.point.size(), patches.points());
  patches.more_begin.push_back(0);
  for (size_t i = 0; i < patches.point.size(); ++i) {
    checkpoint_at(i);
    const auto begin = static_cast<size_t>(neighbors.begin[patches.point[i]]),
               end = static_cast<size_t>(neighbors.begin[patches.point[i] + 1]);
    for (size_t k = begin; k < end; ++k) {
      const int32_t other = rank[neighbors.neighbor[k]];
      if (k - begin < room)
        patches.neighbor[room * i + (k - begin)] = other;
      else
        patches.more.push_back(other);
    }
    patches.more_begin.push_back(static_cast<int32_t>(patches.more.size()));
  }
}

static void link_patches(PointPatches &patches) {
  std::vector<int32_t> mark(static_cast<size_t>(patches.patches()), -1);
  patches.link_begin.push_back(0);
  patches.edge_begin.push_back(0);
  for (int32_t p = 0; p < patches.patches(); ++p) {
    checkpoint_at(static_cast<size_t>(p));
    mark[p] = p;
    const auto link_to = [&](int32_t other) {
      if (other < patches.points() && mark[patches.patch_of[other]] != p) {
        mark[patches.patch_of[other]] = p;
        patches.link.push_back(patches.patch_of[other]);
      }
    };
    for (int32_t i = patches.patch_begin[p]; i < patches.patch_begin[p + 1]; ++i) {
      for (int32_t k = 0; k < PointPatches::near_neighbors; ++k) link_to(patches.neighbor[PointPatches::near_neighbors * i + k]);
      for (int32_t k = patches.more_begin[i]; k < patches.more_begin[i + 1]; ++k) link_to(patches.more[k]);
    }
    patches.link_begin.push_back(static_cast<int32_t>(patches.link.size()));
    for (int32_t corner = 3 * patches.triangle_begin[p]; corner < 3 * patches.triangle_begin[p + 1]; ++corner)
      if (patches.twin[corner] < 0) patches.edge.push_back(corner);
    patches.edge_begin.push_back(static_cast<int32_t>(patches.edge.size()));
  }
}

PointPatches build_point_patches(const HalfEdges &half_edges) {
  const PointNeighbors neighbors = find_point_neighbors(half_edges);
  ClusterTree tree = build_point_tree(neighbors);
  PointPatches patches;
  patches.group_begin = cut_tree(tree, group_lanes);
  patches.patch_begin = cut_tree(tree, PointPatches::most_points);
  patches.point = std::move(tree.item);
  for (int32_t p = 0; p < patches.patches(); ++p)
    patches.patch_of.insert(patches.patch_of.end(), static_cast<size_t>(patches.patch_begin[p + 1] - patches.patch_begin[p]), p);
  place_triangles(half_edges, tree.rank, patches);
  place_neighbors(neighbors, tree.rank, patches);
  link_patches(patches);
  return patches;
}

} // namespace paradesc
