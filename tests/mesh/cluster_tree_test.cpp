// Clusters: every triangle once, connected, in halves.
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
  ClusterTree tree;
};

Built build(const TestMesh &mesh) {
  Built built;
  built.half_edges = build_half_edges(read_triangles(input_of(mesh)));
  built.tree = build_cluster_tree(built.half_edges);
  return built;
}

// The triangles of a cluster: a range of those of the tree.
std::vector<int32_t> triangles_of(const ClusterTree &tree, size_t level, size_t cluster) {
  auto begin = static_cast<int32_t>(cluster), end = begin + 1;
  for (; level > 0; --level) {
    begin = tree.child_begin[level - 1][static_cast<size_t>(begin)];
    end = tree.child_begin[level - 1][static_cast<size_t>(end)];
  }
  return {tree.item.begin() + begin, tree.item.begin() + end};
}

// Pieces that these triangles fall into, over their edges.
size_t pieces_of(const HalfEdges &half_edges, std::vector<int32_t> triangles) {
  std::vector<int32_t> piece(half_edges.twin.size() / 3, -1), stack;
  for (const int32_t triangle : triangles) piece[static_cast<size_t>(triangle)] = 0;
  size_t pieces = 0;
  for (const int32_t first : triangles) {
    if (piece[static_cast<size_t>(first)] != 0) continue;
    ++pieces;
    piece[static_cast<size_t>(first)] = 1;
    stack.assign(1, first);
    while (!stack.empty()) {
      const int32_t triangle = stack.back();
      stack.pop_back();
      for (int32_t half_edge = 3 * triangle; half_edge < 3 * triangle + 3; ++half_edge) {
        const int32_t twin = half_edges.twin[static_cast<size_t>(half_edge)];
        if (twin < 0 || piece[static_cast<size_t>(twin / 3)] != 0) continue;
        piece[static_cast<size_t>(twin / 3)] = 1;
        stack.push_back(twin / 3);
      }
    }
  }
  return pieces;
}

TEST(ClusterTree, has_every_triangle_once) {
  const auto [half_edges, tree] = build(torus(1, 0.4, {.vertices = 3000}));
  std::vector<int32_t> sorted = tree.item, all(half_edges.twin.size() / 3);
  std::iota(all.begin(), all.end(), 0);
  std::ranges::sort(sorted);
  EXPECT_EQ(sorted, all);
  for (size_t i = 0; i < tree.item.size(); ++i) EXPECT_EQ(tree.rank[static_cast<size_t>(tree.item[i])], static_cast<int32_t>(i));
}

TEST(ClusterTree, clusters_are_connected_and_grow_to_the_whole) {
  const auto [half_edges, tree] = build(torus(1, 0.4, {.vertices = 3000}));
  EXPECT_EQ(tree.size(tree.levels() - 1), 1u);
  for (size_t level = 1; level < tree.levels(); ++level) {
    EXPECT_LT(tree.size(level), 0.6 * static_cast<double>(tree.size(level - 1))) << "clusters take a neighbor each";
    for (size_t i = 0; i < tree.size(level); ++i)
      ASSERT_EQ(pieces_of(half_edges, triangles_of(tree, level, i)), 1u) << "level " << level;
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
  const auto [half_edges, tree] = build(two);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(tree.size(tree.levels() - 1), 2u);
}

} // namespace
} // namespace paradesc::test
