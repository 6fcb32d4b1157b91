// Triangles that are large against the radius: they are summed by samples, also where a ball contains none of their corners.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "engine/cpu/exact_surface.h"
#include "engine/cpu/sheets.h"
#include "support/solids.h"
#include "support/surfaces.h"
#include "support/triangle_lists.h"

namespace paradesc::test {
namespace {

using shapes::Shape;

ExactSurface sphere_of(int vertices) { return ExactSurface(read_triangles(input_of(sphere(1.0, {.vertices = vertices})))); }

// A square of side 2 in the plane, of two triangles.
ExactSurface square() {
  return ExactSurface(shapes::triangles_of({{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {0, 1, 2, 0, 2, 3}}));
}

// Returns how many listed triangles have too many samples to be stored.
int64_t divided_triangles(const ExactSurface &surface, double radius, const ExactSetting &setting) {
  const float unit = surface.scaled(radius);
  const ListedSurface listed(surface, surface.patches_for(radius, setting), {.large = 1.25f * unit},
                             {setting.triangles * unit * unit}, SampledTriangles::large);
  int64_t count = 0;
  listed.for_each_item([&](const SampleBlock &block, int32_t k) { count += block.is_divided(k) ? 1 : 0; });
  return count;
}

// Shares of the largest value, about twice as large as measured. By moments, samples are ten times as large as one by one, and
// the normals of a sphere of few triangles turn on them. The bending of long strips is that of the few triangles at a center.
const std::vector<double> &shares(const ExactSetting &setting, bool are_strips = false) {
  static const std::vector<double> of_moments{0.005, 0.01, 0.002}, of_triangles{0.0001, 0.0005, 0.0001, 0.0001},
      of_strips{0.001, 0.03, 0.002, 0.0002};
  return setting.kind == SumKind::fit ? of_moments : are_strips ? of_strips : of_triangles;
}

TEST(ExactLarge, triangles_have_the_values_of_the_reference) {
  const ExactSurface ball = sphere_of(100), cube(box(3));
  for (const ExactSetting &setting : both_ways())
    for (const ExactSurface *const surface : {&ball, &cube}) expect_near_the_reference(*surface, 0.15, setting, shares(setting));
}

TEST(ExactLarge, triangles_that_each_group_divides_have_the_values_of_the_reference) {
  const ExactSurface surface = sphere_of(24);
  for (const ExactSetting &setting : both_ways()) {
    EXPECT_GT(divided_triangles(surface, 0.02, setting), 20);
    expect_near_the_reference(surface, 0.02, setting, shares(setting));
  }
}

// The places are in the middle of a triangle, beside the diagonal, on it, and beside the border.
TEST(ExactLarge, triangles_are_summed_around_centers_without_any_corner_in_the_ball) {
  const ExactSurface surface = square();
  ExactSetting setting = one_by_one();
  setting.rows = rows_named({"mean_curvature", "euclidean_area", "geodesic_area"});
  const double radius = 0.05, disk = 3.14159265358979 * radius * radius;
  const std::vector<vec3> places{{0.3f, -0.3f, 0}, {0.01f, -0.01f, 0}, {0.2f, 0.2f, 0}, {-0.41f, -0.4f, 0}, {0.97f, -0.5f, 0}};
  CenterPoints centers;
  for (const vec3 place : places)
    centers.push_back({surface.space.to_buffer(place), {0.0f, 0.0f, 1.0f}, place.x < place.y ? 1 : 0, -1});
  const CenterResults found = surface.evaluate_at(radius, setting, centers);
  const CenterResults curved = surface.evaluate_at(radius, by_moments(), centers);
  for (size_t i = 0; i < places.size(); ++i) {
    const bool at_border = i == 4;
    EXPECT_EQ(found.boundary[i], at_border ? 1 : 0) << i;
    EXPECT_EQ(curved.boundary[i], at_border ? 1 : 0) << i;
    if (at_border) continue;
    // Arcs are series, and floats round a thousand samples.
    EXPECT_NEAR(found.values[0][i], 0.0f, 1e-4f) << i;
    EXPECT_NEAR(curved.values[0][i], 0.0f, 1e-4f) << i;
    EXPECT_NEAR(found.values[1][i] / disk, 1.0, 1e-5) << i;
    EXPECT_NEAR(found.values[2][i] / disk, 1.0, 1e-5) << i;
  }
}

float shallow(float x, float y) { return 0.05f * (x * x + 0.3f * y * y); }

// Strips whose triangles are eight radii long and half a radius wide: most of a ball is of triangles with no corner in it.
TEST(ExactLarge, long_triangles_count_whose_edges_dip_into_the_ball) {
  const ExactSurface surface(shapes::triangles_of(shapes::sheet(12, 16.0f, shallow)));
  for (const ExactSetting &setting : both_ways()) expect_near_the_reference(surface, 0.33, setting, shares(setting, true));
}

TEST(ExactLarge, triangles_have_the_same_bits_by_every_set_of_instructions_and_any_number_of_threads) {
  const ExactSurface surface = sphere_of(100);
  for (const ExactSetting &setting : both_ways())
    for (const double radius : {0.04, 0.15}) expect_the_same_bits_everywhere(surface, radius, setting);
}

} // namespace
} // namespace paradesc::test
