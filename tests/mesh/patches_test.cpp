// Patches of triangles: whole, connected, and linked where they share points.
#include "mesh/patches.h"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "support/surfaces.h"

namespace paradesc::test {
namespace {

size_t at(int32_t index) { return static_cast<size_t>(index); }

// The triangles of the patch that its first one leads to over edges within it.
size_t connected(const Patches &patches, const HalfEdges &half_edges, size_t patch) {
  std::set<int32_t> found{patches.triangle[at(patches.begin[patch])]};
  std::vector<int32_t> queue(found.begin(), found.end());
  for (size_t i = 0; i < queue.size(); ++i)
    for (int32_t side = 0; side < 3; ++side) {
      const int32_t twin = half_edges.twin[at(3 * queue[i] + side)];
      if (twin >= 0 && patches.triangle_patch[at(twin / 3)] == static_cast<int32_t>(patch) && found.insert(twin / 3).second)
        queue.push_back(twin / 3);
    }
  return found.size();
}

void expect_sound(const Patches &patches, const HalfEdges &half_edges) {
  std::map<int32_t, std::set<int32_t>> patches_of; // by points
  std::vector<int> seen(patches.triangle_patch.size(), 0);
  for (size_t patch = 0; patch < patches.count(); ++patch) {
    const auto first = at(patches.begin[patch]), last = at(patches.begin[patch + 1]);
    ASSERT_GT(last, first);
    ASSERT_LE(last - first, Patches::max_triangles);
    EXPECT_EQ(connected(patches, half_edges, patch), last - first) << patch;
    const int32_t *points = &patches.point[at(patches.point_begin[patch])];
    for (size_t k = first; k < last; ++k) {
      ++seen[at(patches.triangle[k])];
      EXPECT_EQ(patches.triangle_patch[at(patches.triangle[k])], static_cast<int32_t>(patch));
      for (size_t i = 0; i < 3; ++i)
        EXPECT_EQ(points[patches.corner[3 * k + i]], half_edges.corner_point[3 * at(patches.triangle[k]) + i]);
    }
    for (int32_t k = patches.point_begin[patch]; k < patches.point_begin[patch + 1]; ++k)
      EXPECT_TRUE(patches_of[patches.point[at(k)]].insert(static_cast<int32_t>(patch)).second) << "a point comes once";
  }
  for (size_t t = 0; t < seen.size(); ++t)
    EXPECT_EQ(seen[t], half_edges.corner_point[3 * t] >= 0 ? 1 : 0) << t << ": each triangle is in one, but for those left out";
  for (size_t patch = 0; patch < patches.count(); ++patch)
    for (int32_t k = patches.point_begin[patch]; k < patches.point_begin[patch + 1]; ++k) {
      std::set<int32_t> others(patches.link.begin() + patches.link_begin[at(k)],
                               patches.link.begin() + patches.link_begin[at(k) + 1]);
      others.insert(static_cast<int32_t>(patch));
      EXPECT_EQ(others, patches_of[patches.point[at(k)]]);
    }
}

TEST(Patches, hold_each_triangle_of_a_torus_once_and_are_nearly_full) {
  const Triangles triangles = read_triangles(input_of(torus(1.0, 0.4, {.vertices = 5000})));
  const HalfEdges half_edges = build_half_edges(triangles);
  const Patches patches = build_patches(half_edges);
  expect_sound(patches, half_edges);
  // Otherwise floods over them would look at as many things as floods over triangles.
  EXPECT_LT(patches.count(), 3 * at(triangles.triangle_count) / Patches::max_triangles);
}

TEST(Patches, of_an_open_surface_and_of_several_parts_are_sound) {
  const TestMesh open = saddle(1.0, {.vertices = 400});
  std::vector<float> positions = open.positions;
  std::vector<int32_t> corners = open.corner_vertices, triangle_corners;
  for (size_t i = 0; i < open.positions.size(); ++i) positions.push_back(open.positions[i] + 10.0f);
  for (const int32_t vertex : open.corner_vertices) corners.push_back(vertex + open.vertex_count);
  corners.insert(corners.end(), {0, 0, 1}); // no area
  for (size_t i = 0; i < corners.size(); ++i) triangle_corners.push_back(static_cast<int32_t>(i));
  pdesc_mesh_input input;
  pdesc_mesh_input_init(&input);
  input.vertex_count = 2 * open.vertex_count;
  input.corner_count = static_cast<int32_t>(corners.size());
  input.triangle_count = input.corner_count / 3;
  input.positions = positions.data();
  input.corner_vertices = corners.data();
  input.triangle_corners = triangle_corners.data();
  const HalfEdges half_edges = build_half_edges(read_triangles(input));
  const Patches patches = build_patches(half_edges);
  ASSERT_EQ(half_edges.degenerate_triangles, 1);
  EXPECT_EQ(patches.triangle_patch.back(), -1);
  expect_sound(patches, half_edges);
}

TEST(Patches, of_nothing_are_none) { EXPECT_EQ(build_patches({}).count(), 0u); }

} // namespace
} // namespace paradesc::test
