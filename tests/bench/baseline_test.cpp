// The baseline of the benchmarks computes what it says: it would be no straw man, nor a shortcut.
#include "bench/baseline.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "support/surfaces.h"

namespace paradesc::bench {
namespace {

struct Made {
  test::TestMesh mesh;
  Triangles triangles;
  HalfEdges half_edges;
  BaselineSurface surface;
};

Made make(test::TestMesh mesh) {
  Made made;
  made.mesh = std::move(mesh);
  made.triangles = read_triangles(test::input_of(made.mesh));
  made.half_edges = build_half_edges(made.triangles);
  std::vector<vec3> normals;
  for (const int32_t vertex : made.half_edges.point_vertex) {
    const test::Vec3 &normal = made.mesh.normals[static_cast<size_t>(vertex)];
    normals.emplace_back(normal.x, normal.y, normal.z);
  }
  made.surface = build_baseline(made.triangles, made.half_edges, normals);
  return made;
}

TEST(Baseline, has_a_spheres_mean_curvature_within_the_steps_of_its_weights) {
  const Made made = make(test::sphere(2.0, {.vertices = 4000}));
  const std::vector<int32_t> requested = choose_points(made.surface, 0, 1);
  std::vector<float> values(requested.size());
  const BaselineRun run = run_baseline(made.surface, 0.8, requested, 1, values);
  // A ball holds some 160 vertices, so its rim comes in steps: a sphere has no bias beside that.
  double mean = 0.0;
  for (const float value : values) {
    EXPECT_NEAR(value, 0.5, 0.02);
    mean += static_cast<double>(value) / static_cast<double>(values.size());
  }
  EXPECT_NEAR(mean, 0.5, 0.001);
  EXPECT_GT(run.neighbors, 100 * static_cast<int64_t>(values.size()));
}

TEST(Baseline, finds_the_vertices_that_lie_in_the_ball_and_hang_together_there) {
  const Made made = make(test::torus(1.0, 0.4, {.vertices = 2000}));
  const std::vector<int32_t> requested = choose_points(made.surface, 0, 1);
  std::vector<float> values(requested.size());
  const double radius = 0.35; // below the tube's width: within it the ball holds one part
  int64_t inside = 0;
  for (const WeightedPoint &a : made.surface.points)
    for (const WeightedPoint &b : made.surface.points)
      inside += &a != &b && (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z) <= 0.35f * 0.35f;
  EXPECT_EQ(run_baseline(made.surface, radius, requested, 1, values).neighbors, inside);
}

TEST(Baseline, weights_of_vertices_are_the_area_of_the_surface) {
  const Made made = make(test::torus(1.0, 0.4, {.vertices = 2000}));
  double area = 0.0, smallest = 1.0;
  for (const WeightedPoint &point : made.surface.points) {
    area += static_cast<double>(point.area);
    smallest = std::min(smallest, static_cast<double>(point.area));
  }
  EXPECT_NEAR(area, 4.0 * pi * pi * 0.4, 0.05); // of the facets: 0.3 % less than that of the torus
  EXPECT_GT(smallest, 0.0);
}

TEST(Baseline, times_whole_runs_of_neighbors_and_none_twice) {
  const Made made = make(test::torus(1.0, 0.4, {.vertices = 2000}));
  std::vector<int32_t> chosen = choose_points(made.surface, 500, 7);
  EXPECT_EQ(chosen.size(), 512u);
  EXPECT_EQ(std::ranges::adjacent_find(chosen), chosen.end());
  EXPECT_LT(chosen.back(), static_cast<int32_t>(made.surface.points.size()));
}

} // namespace
} // namespace paradesc::bench
