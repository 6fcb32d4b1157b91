// Clusters: every point once, connected, in halves.
#include "mesh/cluster_tree.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "support/surfaces.h"

namespace paradesc::test {
namespace {

struct Built {
  HalfEdges half_edges;
  PointNeighbors neighbors;
  ClusterTree tree;
};

Built build(const TestMesh &mesh) {
  Built built;
  built.half_edges = build_half_edges(read_triangles(input_of(mesh)));
  built.neighbors = find_point_neighbors(built.half_edges);
  built.tree = build_point_tree(built.neighbors);
  return built;
}

// The points of a cluster: a range of those of the tree.
std::vector<int32_t> points_of(const ClusterTree &tree, size_t level, size_t cluster) {
  auto begin = static_cast<int32_t>(cluster), end = begin + 1;
  for (; level > 0; --level) {
    begin = tree.child_begin[level - 1][static_cast<size_t>(begin)];
    end = tree.child_begin[level - 1][static_cast<size_t>(end)];
  }
  return {tree.item.begin() + begin, tree.item.begin() + end};
}

// Pieces that these points fall into, over edges between them.
size_t pieces_of(const PointNeighbors &neighbors, const std::vector<int32_t> &points) {
  std::vector<int32_t> piece(neighbors.begin.size() - 1, -1), stack;
  for (const int32_t point : points) piece[static_cast<size_t>(point)] = 0;
  size_t pieces = 0;
  for (const int32_t first : points) {
    if (piece[static_cast<size_t>(first)] != 0) continue;
    ++pieces;
    piece[static_cast<size_t>(first)] = 1;
    stack.assign(1, first);
    while (!stack.empty()) {
      const auto point = static_cast<size_t>(stack.back());
      stack.pop_back();
      for (int32_t k = neighbors.begin[point]; k < neighbors.begin[point + 1]; ++k) {
        const int32_t other = neighbors.neighbor[static_cast<size_t>(k)];
        if (piece[static_cast<size_t>(other)] != 0) continue;
        piece[static_cast<size_t>(other)] = 1;
        stack.push_back(other);
      }
    }
  }
  return pieces;
}

TEST(ClusterTree, has_every_point_once) {
  const auto [half_edges, neighbors, tree] = build(torus(1, 0.4, {.vertices = 3000}));
  std::vector<int32_t> sorted = tree.item, all(static_cast<size_t>(half_edges.point_count));
  std::iota(all.begin(), all.end(), 0);
  std::ranges::sort(sorted);
  EXPECT_EQ(sorted, all);
  for (size_t i = 0; i < tree.item.size(); ++i) EXPECT_EQ(tree.rank[static_cast<size_t>(tree.item[i])], static_cast<int32_t>(i));
}

TEST(ClusterTree, clusters_are_connected_and_grow_to_the_whole) {
  const auto [half_edges, neighbors, tree] = build(torus(1, 0.4, {.vertices = 3000}));
  EXPECT_EQ(tree.size(tree.levels() - 1), 1u);
  for (size_t level = 1; level < tree.levels(); ++level) {
    EXPECT_LT(tree.size(level), 0.6 * static_cast<double>(tree.size(level - 1))) << "clusters take a neighbor each";
    for (size_t i = 0; i < tree.size(level); ++i)
      ASSERT_EQ(pieces_of(neighbors, points_of(tree, level, i)), 1u) << "level " << level;
  }
}

TEST(ClusterTree, parts_of_a_mesh_share_no_cluster) {
  const TestMesh one = sphere(1, {.vertices = 300});
  TestMesh two = one;
  for (size_t i = 0; i < one.positions.size(); ++i) two.positions.push_back(one.positions[i] + (i % 3 == 0 ? 3.0f : 0.0f));
  for (const int32_t vertex : one.corner_vertices) two.corner_vertices.push_back(vertex + one.vertex_count);
  for (const int32_t corner : one.triangle_corners)
    two.triangle_corners.push_back(corner + static_cast<int32_t>(one.corner_vertices.size()));
  two.vertex_count *= 2;
  two.corner_uvs.clear();
  two.corner_normals.clear();
  const auto [half_edges, neighbors, tree] = build(two);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(tree.size(tree.levels() - 1), 2u);
}

} // namespace
} // namespace paradesc::test
