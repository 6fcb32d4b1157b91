// Nodes and patches: every point and every triangle once, small connected clusters that hide no detail, and their adjacency.
#include "engine/cpu/point_clusters.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/cpu/patched_mesh.h"
#include "engine/cpu/sheets.h"
#include "support/surfaces.h"
#include "support/triangle_lists.h"

namespace paradesc::test {
namespace {

using shapes::at, shapes::bowl, shapes::sheet;

constexpr float spread = 0.006f, coherence = 0.9f; // in squares of the mesh's units

float square_of_scale(const PatchedMesh &mesh) { return mesh.scaled(1.0) * mesh.scaled(1.0); }
std::vector<int32_t> clustered(const PatchedMesh &mesh) { return mesh.nodes({spread * square_of_scale(mesh), coherence}); }

// Some meshes with clusters and single points, the last one with open borders.
std::vector<PatchedMesh> meshes() {
  std::vector<PatchedMesh> found;
  found.emplace_back(read_triangles(input_of(torus(1.0, 0.4, {.vertices = 15000}))));
  found.emplace_back(read_triangles(input_of(sphere(1.0, {.vertices = 8000}))));
  found.emplace_back(shapes::triangles_of(sheet(56, 1.0f, bowl)));
  return found;
}

std::span<const int32_t> points_of(const PatchedMesh &mesh, const std::vector<int32_t> &node_begin, int32_t node) {
  return std::span(mesh.order.tree.item).subspan(at(node_begin[at(node)]), at(node_begin[at(node) + 1] - node_begin[at(node)]));
}

std::span<const int32_t> part(const std::vector<int32_t> &items, const std::vector<int32_t> &begin, int32_t index) {
  return std::span(items).subspan(at(begin[at(index)]), at(begin[at(index) + 1] - begin[at(index)]));
}

bool is_each_once(std::vector<int32_t> items, int32_t count) {
  std::ranges::sort(items);
  bool each = items.size() == at(count);
  for (size_t i = 0; each && i < items.size(); ++i) each = items[i] == static_cast<int32_t>(i);
  return each;
}

// Returns how many of the points are reached from the first along edges between them.
size_t connected(const PatchedMesh &mesh, std::span<const int32_t> points) {
  std::set<int32_t> rest(points.begin() + 1, points.end());
  std::vector<int32_t> reached{points[0]};
  for (size_t i = 0; i < reached.size(); ++i)
    for (const int32_t next : part(mesh.order.neighbors.neighbor, mesh.order.neighbors.begin, reached[i]))
      if (rest.erase(next) > 0) reached.push_back(next);
  return reached.size();
}

std::set<int32_t> neighbors_of(const PointPatches &patches, int32_t node) {
  std::set<int32_t> found;
  for (size_t k = 0; k < at(PointPatches::near_neighbors); ++k)
    found.insert(patches.neighbor[at(PointPatches::near_neighbors * node) + k]);
  found.erase(patches.nodes());
  for (const int32_t other : part(patches.more, patches.more_begin, node)) found.insert(other);
  return found;
}

TEST(PointClusters, have_every_point_in_one_node) {
  for (const PatchedMesh &mesh : meshes())
    for (const std::vector<int32_t> &begin : {mesh.single_points(), clustered(mesh)}) {
      const PointPatches patches = mesh.patches(begin);
      EXPECT_TRUE(is_each_once(mesh.order.tree.item, mesh.half_edges.point_count));
      EXPECT_EQ(begin.front(), 0);
      EXPECT_EQ(begin.back(), mesh.half_edges.point_count);
      ASSERT_EQ(at(patches.nodes()) + 1, begin.size());
      int32_t clusters = 0;
      for (int32_t node = 0; node < patches.nodes(); ++node) {
        const std::span<const int32_t> points = points_of(mesh, begin, node);
        ASSERT_FALSE(points.empty());
        for (const int32_t point : points) EXPECT_EQ(patches.node_of_point[at(point)], node);
        EXPECT_EQ(patches.node[at(node)], points.size() == 1 ? points[0] : ~clusters);
        if (points.size() == 1) continue;
        ASSERT_LT(clusters, patches.clusters());
        EXPECT_EQ(patches.cluster_node[at(clusters++)], node);
      }
      EXPECT_EQ(patches.clusters(), clusters);
    }
}

TEST(PointClusters, have_every_triangle_in_one_cluster_or_by_itself) {
  for (const PatchedMesh &mesh : meshes())
    for (const std::vector<int32_t> &begin : {mesh.single_points(), clustered(mesh)}) {
      const PointPatches patches = mesh.patches(begin);
      std::vector<int32_t> all = patches.triangle;
      all.insert(all.end(), patches.member.begin(), patches.member.end());
      EXPECT_TRUE(is_each_once(all, mesh.triangles.triangle_count));
      const auto node_of = [&](int32_t corner) { return patches.node_of_point[at(mesh.half_edges.corner_point[at(corner)])]; };
      for (int32_t place = 0; place < static_cast<int32_t>(patches.triangle.size()); ++place) {
        const int32_t t = patches.triangle[at(place)];
        EXPECT_EQ(patches.place[at(t)], place);
        for (int32_t k = 0; k < 3; ++k) {
          EXPECT_EQ(patches.corner[at(3 * place + k)], node_of(3 * t + k));
          EXPECT_GE(patches.node[at(node_of(3 * t + k))], 0) << "single triangles have points as corners";
        }
      }
      for (int32_t cluster = 0; cluster < patches.clusters(); ++cluster)
        for (const int32_t t : part(patches.member, patches.member_begin, cluster)) {
          const int32_t node = patches.cluster_node[at(cluster)];
          EXPECT_EQ(patches.place[at(t)], -1);
          EXPECT_EQ(patches.node_of_triangle[at(t)], node);
          EXPECT_TRUE(node == node_of(3 * t) || node == node_of(3 * t + 1) || node == node_of(3 * t + 2));
        }
    }
}

// Spreads are sums of floats over some hundred points.
TEST(PointClusters, are_connected_and_no_wider_than_the_limit) {
  for (const PatchedMesh &mesh : meshes()) {
    const std::vector<int32_t> begin = clustered(mesh);
    const std::vector<vec3> positions = mesh.positions();
    int32_t in_clusters = 0;
    for (int32_t node = 0; node + 1 < static_cast<int32_t>(begin.size()); ++node) {
      const std::span<const int32_t> points = points_of(mesh, begin, node);
      if (points.size() == 1) continue;
      in_clusters += static_cast<int32_t>(points.size());
      EXPECT_EQ(connected(mesh, points), points.size());
      EXPECT_GE(points.size(), 3u) << "fewer are faster one by one";
      vec3 middle(0.0f);
      float wide = 0;
      for (const int32_t point : points) middle += positions[at(point)] / static_cast<float>(points.size());
      for (const int32_t point : points) {
        const vec3 gap = positions[at(point)] - middle;
        wide += dot(gap, gap) / static_cast<float>(points.size());
      }
      EXPECT_LT(wide, 1.001f * spread * square_of_scale(mesh));
    }
    EXPECT_GT(in_clusters, mesh.half_edges.point_count / 2);
  }
}

// A thin ellipsoid has two sides, whose normals are opposite.
TEST(PointClusters, do_not_span_two_sides_of_a_thin_sheet) {
  const PatchedMesh mesh(read_triangles(input_of(ellipsoid(1.0, 1.0, 0.02, {.vertices = 12000}))));
  const std::vector<int32_t> begin = clustered(mesh);
  int32_t clusters = 0;
  for (int32_t node = 0; node + 1 < static_cast<int32_t>(begin.size()); ++node) {
    const std::span<const int32_t> points = points_of(mesh, begin, node);
    if (points.size() == 1) continue;
    ++clusters;
    vec3 mean(0.0f);
    for (const int32_t point : points) mean += mesh.normals.point[at(point)] / static_cast<float>(points.size());
    EXPECT_GT(dot(mean, mean), coherence);
    for (const int32_t point : points) EXPECT_GT(dot(mesh.normals.point[at(point)], mean), 0.0f);
  }
  EXPECT_GT(clusters, 100);
}

TEST(PointClusters, do_not_hide_faces_that_turn) {
  const PatchedMesh mesh(read_triangles(input_of(sphere(1.0, {.vertices = 8000}))));
  const std::vector<vec3> positions = mesh.positions();
  std::vector<vec3> facing = mesh.normals.point; // Around points on one half, faces differ.
  for (size_t i = 0; i < facing.size(); ++i)
    if (positions[i].x > 0.0f) facing[i] *= 0.9f;
  const std::vector<int32_t> begin =
      plan_nodes(mesh.order, {positions, mesh.normals.point, facing}, {spread * square_of_scale(mesh), coherence}, 2);
  bool any = false;
  for (int32_t node = 0; node + 1 < static_cast<int32_t>(begin.size()); ++node) {
    const std::span<const int32_t> points = points_of(mesh, begin, node);
    any = any || points.size() > 1;
    const auto turning = std::ranges::count_if(points, [&](int32_t point) { return positions[at(point)].x > 0.0f; });
    if (points.size() > 1) {
      EXPECT_LT(static_cast<double>(turning), 0.52 * static_cast<double>(points.size())); // (1 - 0.1 * 0.52)^2 < coherence
    }
  }
  EXPECT_TRUE(any);
}

// The order follows from connectivity alone, and so does not know of the frame that came first.
TEST(PointClusters, depend_on_the_positions_of_the_frame_alone) {
  const TestMesh rest = torus(1.0, 0.4, {.vertices = 15000});
  TestMesh bent = rest;
  for (size_t i = 0; i + 2 < bent.positions.size(); i += 3) bent.positions[i + 2] *= 2.0f + bent.positions[i];
  const PatchedMesh first(read_triangles(input_of(rest))), second(read_triangles(input_of(bent)));
  const std::vector<vec3> positions = second.positions();
  const PointSurface surface{positions, second.normals.point, {}};
  const ClusterLimit limit{spread * square_of_scale(second), coherence};
  const std::vector<int32_t> plan = plan_nodes(second.order, surface, limit, 1);
  EXPECT_EQ(plan_nodes(first.order, surface, limit, 1), plan);
  EXPECT_EQ(plan_nodes(second.order, surface, limit, 3), plan) << "by any number of threads";
  EXPECT_NE(clustered(first), plan) << "the frames differ";
}

TEST(PointClusters, have_mutual_neighbors_that_share_an_edge) {
  for (const PatchedMesh &mesh : meshes()) {
    const std::vector<int32_t> begin = clustered(mesh);
    const PointPatches patches = mesh.patches(begin);
    std::vector<std::set<int32_t>> expected(at(patches.nodes()));
    for (int32_t point = 0; point < mesh.half_edges.point_count; ++point)
      for (const int32_t other : part(mesh.order.neighbors.neighbor, mesh.order.neighbors.begin, point))
        expected[at(patches.node_of_point[at(point)])].insert(patches.node_of_point[at(other)]);
    for (int32_t node = 0; node < patches.nodes(); ++node) {
      expected[at(node)].erase(node);
      ASSERT_EQ(neighbors_of(patches, node), expected[at(node)]) << "node " << node;
      for (const int32_t other : expected[at(node)]) EXPECT_TRUE(neighbors_of(patches, other).contains(node));
    }
    std::set<std::pair<int32_t, int32_t>> links;
    for (int32_t patch = 0; patch < patches.patches(); ++patch)
      for (const int32_t other : part(patches.link, patches.link_begin, patch)) links.emplace(patch, other);
    for (const auto &[patch, other] : links) EXPECT_TRUE(links.contains({other, patch}));
    for (int32_t node = 0; node < patches.nodes(); ++node)
      for (const int32_t other : expected[at(node)]) {
        const int32_t here = patches.patch_of[at(node)], there = patches.patch_of[at(other)];
        EXPECT_TRUE(here == there || links.contains({here, there}));
      }
  }
}

TEST(PointClusters, have_twins_except_at_boundaries_and_clusters) {
  for (const PatchedMesh &mesh : meshes())
    for (const std::vector<int32_t> &begin : {mesh.single_points(), clustered(mesh)}) {
      const PointPatches patches = mesh.patches(begin);
      int32_t boundaries = 0;
      for (int32_t corner = 0; corner < static_cast<int32_t>(patches.twin.size()); ++corner) {
        const int32_t t = patches.triangle[at(corner / 3)], twin = mesh.half_edges.twin[at(3 * t + corner % 3)];
        const int32_t found = patches.twin[at(corner)];
        boundaries += found == -1 ? 1 : 0;
        EXPECT_EQ(found == -1, twin < 0);
        if (twin < 0) continue;
        EXPECT_EQ(found == -2, patches.place[at(twin / 3)] < 0);
        if (found < 0) continue;
        EXPECT_EQ(patches.triangle[at(found / 3)], twin / 3);
        EXPECT_EQ(patches.twin[at(found)], corner);
      }
      EXPECT_EQ(at(boundaries), patches.edge.size());
    }
}

TEST(PointClusters, are_in_patches_of_up_to_eight_nodes_and_groups_of_up_to_sixteen_points) {
  for (const PatchedMesh &mesh : meshes()) {
    const PointPatches patches = mesh.patches(clustered(mesh));
    for (int32_t patch = 0; patch < patches.patches(); ++patch) {
      const int32_t first = patches.patch_begin[at(patch)], last = patches.patch_begin[at(patch) + 1];
      EXPECT_GT(last, first);
      EXPECT_LE(last - first, PointPatches::most_nodes);
      for (int32_t node = first; node < last; ++node) EXPECT_EQ(patches.patch_of[at(node)], patch);
      for (int32_t k = patches.cluster_begin[at(patch)]; k < patches.cluster_begin[at(patch) + 1]; ++k)
        EXPECT_EQ(patches.patch_of[at(patches.cluster_node[at(k)])], patch);
      for (const int32_t t : part(patches.triangle, patches.triangle_begin, patch))
        EXPECT_EQ(patches.patch_of[at(patches.node_of_triangle[at(t)])], patch);
    }
    const std::vector<int32_t> groups = group_points(mesh.order, group_lanes);
    EXPECT_EQ(groups.front(), 0);
    EXPECT_EQ(groups.back(), mesh.half_edges.point_count);
    for (size_t g = 0; g + 1 < groups.size(); ++g) {
      EXPECT_GT(groups[g + 1], groups[g]);
      EXPECT_LE(groups[g + 1] - groups[g], group_lanes);
    }
  }
}

// In the order of shuffled triangles, pairs leave single points behind, and a group has ten points.
TEST(PointOrder, fills_groups_about_as_well_in_any_order_of_the_triangles) {
  const TestMesh ordered = torus(1, 0.4, {.vertices = 10000});
  TestMesh shuffled = ordered;
  std::vector<size_t> order(ordered.triangle_corners.size() / 3);
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::shuffle(order, std::mt19937(1));
  for (size_t i = 0; i < order.size(); ++i)
    std::copy_n(ordered.triangle_corners.begin() + static_cast<ptrdiff_t>(3 * order[i]), 3,
                shuffled.triangle_corners.begin() + static_cast<ptrdiff_t>(3 * i));
  for (const TestMesh &mesh : {ordered, shuffled}) {
    const PointOrder points = order_points(build_half_edges(read_triangles(input_of(mesh))));
    EXPECT_GT(points.points() / static_cast<double>(points.group_begin.size() - 1), 14.0) << "of " << group_lanes;
  }
}

} // namespace
} // namespace paradesc::test
