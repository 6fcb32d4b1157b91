// Sums over clusters of many small triangles: nearly the reference's values, and the same bits everywhere.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "engine/cpu/exact_surface.h"
#include "engine/cpu/sheets.h"
#include "support/surfaces.h"
#include "support/triangle_lists.h"

namespace paradesc::test {
namespace {

using shapes::bowl, shapes::dome, shapes::Shape, shapes::sheet;

constexpr double radius = 0.6;

std::vector<ExactSetting> settings() {
  std::vector<ExactSetting> both = both_ways();
  for (ExactSetting &setting : both) setting.clusters = 0.006f;
  return both;
}

ExactSurface torus_of(int vertices) { return ExactSurface(read_triangles(input_of(torus(1.0, 0.4, {.vertices = vertices})))); }

// Returns the share of the points that lie in clusters.
double clustered_share(const ExactSurface &surface, const ExactSetting &setting) {
  const PointPatches patches = surface.patches_for(radius, setting);
  const auto single = std::ranges::count_if(patches.node, [](int32_t node) { return node >= 0; });
  return 1.0 - static_cast<double>(single) / static_cast<double>(surface.half_edges.point_count);
}

// The reference is slow, so it computes some points.
std::vector<int32_t> some_points(const ExactSurface &surface, int32_t step) {
  std::vector<int32_t> points;
  for (int32_t i = 0; i < surface.half_edges.point_count; i += step) points.push_back(i);
  return points;
}

void expect_values_near_the_reference(const ExactSurface &surface, const ExactSetting &setting,
                                      const std::vector<double> &shares) {
  EXPECT_GT(clustered_share(surface, setting), 0.8);
  const std::vector<int32_t> at = some_points(surface, 97);
  expect_values_near(surface.evaluate(radius, setting).values, surface.reference(radius, setting.rows, at).values, setting.rows,
                     shares, at);
}

// A radius is 28 edges long. Shares of the largest value are about twice those measured: the rim cuts clusters by their variance,
// and within them, normals are linear.
TEST(ExactClusters, have_nearly_the_values_of_the_reference) {
  const ExactSurface surface = torus_of(40000);
  for (ExactSetting setting : settings()) {
    if (setting.kind != SumKind::fit)
      setting.rows = rows_named({"mean_curvature", "local_bending_energy", "euclidean_area", "sphere_volume"});
    expect_values_near_the_reference(surface, setting,
                                     setting.kind == SumKind::fit ? std::vector{0.004, 0.006, 0.015}
                                                                  : std::vector{0.004, 0.008, 0.005, 0.004});
  }
}

const std::vector<double> of_moments_on_sheets{0.0005, 0.001, 0.02}, of_triangles_on_sheets{0.0005, 0.004, 0.005, 0.0004};
const std::vector<double> &of_sheets(const ExactSetting &setting) {
  return setting.kind == SumKind::fit ? of_moments_on_sheets : of_triangles_on_sheets;
}

// A sheet bends less than the torus.
TEST(ExactClusters, have_nearly_the_values_of_the_reference_beside_open_borders) {
  const ExactSurface surface(shapes::triangles_of(sheet(100, 1.0f, bowl)));
  for (const ExactSetting &setting : settings()) expect_values_near_the_reference(surface, setting, of_sheets(setting));
}

TEST(ExactClusters, leave_out_a_sheet_that_is_near_but_not_connected) {
  const ExactSurface surface(shapes::triangles_of(shapes::join(sheet(100, 1.0f, bowl), sheet(100, 1.0f, dome, 0.05f))));
  ASSERT_EQ(surface.half_edges.components, 2);
  for (const ExactSetting &setting : settings()) expect_values_near_the_reference(surface, setting, of_sheets(setting));
}

TEST(ExactClusters, know_where_the_boundary_is_near) {
  const ExactSurface surface(shapes::triangles_of(sheet(100, 1.0f, bowl)));
  const std::vector<int32_t> at = some_points(surface, 37);
  for (const ExactSetting &setting : settings()) {
    const CenterResults found = surface.evaluate(radius, setting);
    const ReferenceField reference = surface.reference(radius, setting.rows, at);
    for (const int32_t point : at)
      EXPECT_EQ(found.boundary[static_cast<size_t>(point)], reference.boundary[static_cast<size_t>(point)]) << "point " << point;
  }
}

// A square of side 0.4 with a fine grid, in the middle of one of side 2 whose corners all edges of the grid's border are joined
// to.
Shape fine_square_in_a_large_one() {
  constexpr int side = 40;
  Shape shape;
  const auto grid_point = [](int i, int k) { return i * (side + 1) + k; };
  for (int i = 0; i <= side; ++i)
    for (int k = 0; k <= side; ++k)
      shape.positions.emplace_back(0.01f * static_cast<float>(i) - 0.2f, 0.01f * static_cast<float>(k) - 0.2f, 0.0f);
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const int32_t a = grid_point(i, k), b = grid_point(i + 1, k), c = grid_point(i + 1, k + 1), d = grid_point(i, k + 1);
      shape.faces.insert(shape.faces.end(), {a, b, c, a, c, d});
    }
  const auto corner = static_cast<int32_t>(shape.positions.size());
  for (const vec3 position : {vec3(-1, -1, 0), vec3(1, -1, 0), vec3(1, 1, 0), vec3(-1, 1, 0)})
    shape.positions.push_back(position);
  std::vector<int32_t> ring;
  for (int i = 0; i < side; ++i) ring.push_back(grid_point(i, 0));
  for (int i = 0; i < side; ++i) ring.push_back(grid_point(side, i));
  for (int i = side; i > 0; --i) ring.push_back(grid_point(i, side));
  for (int i = side; i > 0; --i) ring.push_back(grid_point(0, i));
  for (int i = 0; i < 4 * side; ++i) {
    const int32_t here = corner + i / side, next = corner + (i / side + 1) % 4;
    shape.faces.insert(shape.faces.end(), {ring[static_cast<size_t>((i + 1) % (4 * side))], ring[static_cast<size_t>(i)],
                                           i % side < side / 2 ? here : next});
    if (i % side == side / 2) shape.faces.insert(shape.faces.end(), {ring[static_cast<size_t>(i)], here, next});
  }
  return shape;
}

// Large triangles with a corner in the fine grid do not end where its clusters do.
TEST(ExactClusters, do_not_take_large_triangles_beside_them) {
  const ExactSurface surface(shapes::triangles_of(fine_square_in_a_large_one()));
  ASSERT_EQ(surface.half_edges.components, 1);
  ExactSetting setting = one_by_one();
  setting.rows = rows_named({"euclidean_area"});
  for (const float clusters : {0.004f, 0.008f}) {
    setting.clusters = clusters;
    const std::vector<int32_t> at = some_points(surface, 17);
    expect_values_near(surface.evaluate(0.3, setting).values, surface.reference(0.3, setting.rows, at).values, setting.rows,
                       {0.01}, at);
  }
}

// The strip between the areas within the radius in space and along the surface is of clusters whose planes are far from the
// center.
TEST(ExactClusters, have_nearly_the_area_within_the_radius_along_the_surface) {
  const ExactSurface surface = torus_of(40000);
  ExactSetting setting = one_by_one();
  setting.rows = rows_named({"geodesic_area"});
  setting.clusters = 0.006f;
  expect_values_near_the_reference(surface, setting, {0.015});
}

// The search begins with the triangle's cluster, or with its corners.
TEST(ExactClusters, are_reached_from_centers_that_are_not_points) {
  const ExactSurface surface(shapes::triangles_of(sheet(60, 1.0f, bowl)));
  for (ExactSetting setting : settings()) {
    setting.clusters = 0.014f;
    EXPECT_GT(clustered_share(surface, setting), 0.5);
    expect_the_same_from_triangles(surface, radius, setting);
  }
}

TEST(ExactClusters, have_the_same_bits_by_every_set_of_instructions_and_any_number_of_threads) {
  const ExactSurface surface = torus_of(8000);
  for (ExactSetting setting : settings()) {
    setting.clusters = 0.024f;
    EXPECT_GT(clustered_share(surface, setting), 0.5);
    expect_the_same_bits_everywhere(surface, radius, setting);
  }
}

} // namespace
} // namespace paradesc::test
