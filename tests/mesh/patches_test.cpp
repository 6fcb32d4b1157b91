// Patches of triangles: whole, connected, and linked where they share edges.
#include "mesh/patches.h"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include "support/surfaces.h"

namespace paradesc::test {
namespace {

size_t at(int32_t index) { return static_cast<size_t>(index); }

// The triangles of the patch that its first one leads to over edges within it.
size_t connected(const Patches &patches, const HalfEdges &half_edges, int32_t patch) {
  std::set<int32_t> found{patches.triangle[at(Patches::max_triangles * patch)]};
  std::vector<int32_t> queue(found.begin(), found.end());
  for (size_t i = 0; i < queue.size(); ++i)
    for (int32_t side = 0; side < 3; ++side) {
      const int32_t code = patches.across(half_edges, 3 * queue[i] + side);
      if (code >= 0 && code / Patches::max_triangles == patch && found.insert(patches.triangle[at(code)]).second)
        queue.push_back(patches.triangle[at(code)]);
    }
  return found.size();
}

void expect_sound(const Patches &patches, const HalfEdges &half_edges) {
  std::vector<int> seen(patches.code.size(), 0);
  for (int32_t patch = 0; patch < patches.count(); ++patch) {
    std::map<int32_t, uint32_t> beside;
    size_t size = 0;
    for (int32_t code = Patches::max_triangles * patch; code < Patches::max_triangles * (patch + 1); ++code) {
      const int32_t triangle = patches.triangle[at(code)];
      if (triangle < 0) continue;
      ASSERT_EQ(patches.code[at(triangle)], code);
      ASSERT_EQ(code, Patches::max_triangles * patch + static_cast<int32_t>(size)) << "those of a patch have no gap";
      ++size;
      ++seen[at(triangle)];
      for (int32_t side = 0; side < 3; ++side)
        if (const int32_t other = patches.across(half_edges, 3 * triangle + side);
            other >= 0 && other / Patches::max_triangles != patch)
          beside[other / Patches::max_triangles] |= uint32_t{1} << other % Patches::max_triangles;
    }
    ASSERT_GT(size, 0u);
    EXPECT_EQ(connected(patches, half_edges, patch), size) << patch;
    std::map<int32_t, uint32_t> listed;
    for (int32_t k = patches.neighbor_begin[at(patch)]; k < patches.neighbor_begin[at(patch) + 1]; ++k) {
      const ivec2 neighbor = patches.neighbor[at(k)];
      EXPECT_TRUE(listed.emplace(neighbor.x, static_cast<uint32_t>(neighbor.y)).second) << "each is listed once";
    }
    EXPECT_EQ(listed, beside) << patch;
  }
  for (size_t t = 0; t < seen.size(); ++t)
    EXPECT_EQ(seen[t], half_edges.corner_point[3 * t] >= 0 ? 1 : 0) << t << ": each triangle is in one, but for those left out";
}

TEST(Patches, hold_each_triangle_of_a_torus_once_and_are_nearly_full) {
  const Triangles triangles = read_triangles(input_of(torus(1.0, 0.4, {.vertices = 5000})));
  const HalfEdges half_edges = build_half_edges(triangles);
  const Patches patches = build_patches(half_edges);
  expect_sound(patches, half_edges);
  // Otherwise floods over them would look at as many things as floods over triangles.
  EXPECT_LT(patches.count(), 3 * triangles.triangle_count / Patches::max_triangles);
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
  EXPECT_EQ(patches.code.back(), -1);
  expect_sound(patches, half_edges);
}

TEST(Patches, of_nothing_are_none) { EXPECT_EQ(build_patches({}).count(), 0); }

} // namespace
} // namespace paradesc::test
