// Sums over all triangles in a ball: the same bits by every set of instructions and any number of threads, and the reference's
// values and boundary flags, also where several parts of a surface lie in one ball.
#include "engine/cpu/exact_pass.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "descriptor/registry.h"
#include "engine/cpu/exact_choice.h"
#include "engine/reference/reference.h"
#include "mesh/extent.h"
#include "support/surfaces.h"
#include "support/triangle_lists.h"

namespace paradesc::test {
namespace {

using shapes::Shape;

const std::vector<int> &rows() {
  static const std::vector<int> all{find_descriptor("mean_curvature"), find_descriptor("gaussian_curvature"),
                                    find_descriptor("standard_error")};
  return all;
}

struct Surfaced {
  explicit Surfaced(Triangles triangles_)
      : triangles(std::move(triangles_)), half_edges(build_half_edges(triangles)),
        normals(compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges), PDESC_NORMALS_FITTED, 1)),
        space(bake_space_of(measure_extent(triangles, half_edges, 1).box)), patches(build_point_patches(half_edges)) {}

  // Values in units of the buffers.
  CenterResults evaluate(double radius, const BallTarget &target, int threads) const {
    PatchSurface surface;
    surface.refit(patches, triangles, half_edges, normals, space, target, true, threads);
    EvaluateParams params{};
    params.radius = static_cast<float>(radius * space.scale);
    CenterResults results = results_at_points(half_edges.point_count);
    for (size_t k = 0; k < rows().size(); ++k)
      results.values.emplace_back(static_cast<size_t>(half_edges.point_count), std::numeric_limits<float>::quiet_NaN());
    results.boundary.assign(static_cast<size_t>(half_edges.point_count), 2);
    evaluate_exactly({patches, surface, target, {SumKind::fit, false}, params, rows(), threads, [](double) {}}, results);
    return results;
  }
  ReferenceField reference(double radius) const {
    return compute_reference(triangles, half_edges, normals, {.radius = radius}, rows(), 2, [](double) { return true; });
  }

  Triangles triangles;
  HalfEdges half_edges;
  Normals normals;
  BakeSpace space;
  PointPatches patches;
};

Surfaced torus_of(int vertices) { return Surfaced(read_triangles(input_of(torus(1.0, 0.4, {.vertices = vertices})))); }

// A sheet over a square of side 2 with steps that are irregular and longer along y.
Shape sheet(int side, float stretch, float (*height)(float x, float y), float lift = 0.0f) {
  std::mt19937 random(7);
  const auto jitter = [&] { return 0.3f * (static_cast<float>(random() % 1024) / 512.0f - 1.0f); };
  Shape shape;
  const float step = 2.0f / static_cast<float>(side);
  for (int i = 0; i <= side; ++i)
    for (int k = 0; k <= side; ++k) {
      const bool middle = 2 * i == side && 2 * k == side;
      const float x = (static_cast<float>(i) + (middle ? 0.0f : jitter())) * step - 1.0f;
      const float y = (static_cast<float>(k) + (middle ? 0.0f : jitter())) * step - 1.0f;
      shape.positions.emplace_back(x, stretch * y, lift + height(x, stretch * y));
    }
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const int32_t a = i * (side + 1) + k, b = a + side + 1;
      shape.faces.insert(shape.faces.end(), {a, b, b + 1, a, b + 1, a + 1});
    }
  return shape;
}
float bowl(float x, float y) { return 0.2f * (x * x + y * y); }
float dome(float x, float y) { return -0.3f * (x * x + y * y); }

// Where both have a value, within a share of the largest.
void expect_near_the_reference(const Surfaced &surface, double radius, double share) {
  const CenterResults found = surface.evaluate(radius, ball_targets()[0], 2);
  const ReferenceField reference = surface.reference(radius);
  const double units[] = {surface.space.scale, surface.space.scale * surface.space.scale, surface.space.scale};
  for (size_t k = 0; k < rows().size(); ++k) {
    double largest = 0, worst = 0;
    for (size_t i = 0; i < reference.values[k].size(); ++i) {
      const auto expected = static_cast<double>(reference.values[k][i]),
                 value = units[k] * static_cast<double>(found.values[k][i]);
      EXPECT_EQ(std::isnan(value), std::isnan(expected)) << "point " << i;
      if (std::isnan(expected)) continue;
      largest = std::max(largest, std::abs(expected));
      worst = std::max(worst, std::abs(value - expected));
    }
    EXPECT_GT(largest, 0) << "row " << k;
    EXPECT_LT(worst, share * largest) << "row " << k;
  }
  EXPECT_EQ(found.boundary, reference.boundary);
}

TEST(ExactPass, has_the_same_bits_by_every_set_of_instructions_and_any_number_of_threads) {
  const Surfaced surface = torus_of(3000);
  const CenterResults first = surface.evaluate(0.2, ball_targets()[0], 1);
  for (const BallTarget &target : ball_targets())
    for (const int threads : {1, 3}) {
      const CenterResults other = surface.evaluate(0.2, target, threads);
      for (size_t k = 0; k < rows().size(); ++k)
        EXPECT_EQ(std::memcmp(other.values[k].data(), first.values[k].data(), first.values[k].size() * sizeof(float)), 0)
            << "row " << k << " by " << target.name << " on " << threads;
    }
}

// Arcs are series, and normals are linear on triangles: less than a per cent where triangles are half as large as the radius, and
// less where they are smaller.
TEST(ExactPass, has_the_values_of_the_reference) {
  const Surfaced surface = torus_of(3000);
  expect_near_the_reference(surface, 0.13, 0.01);
  expect_near_the_reference(surface, 0.3, 0.001);
}

TEST(ExactPass, has_the_values_of_the_reference_beside_open_borders) {
  expect_near_the_reference(Surfaced(shapes::triangles_of(sheet(24, 1.0f, bowl))), 0.3, 0.005);
}

// Both sheets lie in each other's balls, and are curved differently.
TEST(ExactPass, leaves_out_what_is_not_connected_in_the_ball) {
  const Surfaced surface(shapes::triangles_of(shapes::join(sheet(24, 1.0f, bowl), sheet(24, 1.0f, dome, 0.05f))));
  ASSERT_EQ(surface.half_edges.components, 2);
  expect_near_the_reference(surface, 0.3, 0.005);
}

// Two sheets that share the vertex in their middles, which has a point for each.
TEST(ExactPass, keeps_sheets_apart_that_touch_at_a_vertex) {
  const Shape above = sheet(24, 1.0f, bowl);
  Shape both = shapes::join(above, sheet(24, 1.0f, dome));
  const auto count = static_cast<int32_t>(above.positions.size()), middle = count / 2;
  ASSERT_EQ(above.positions[static_cast<size_t>(middle)], vec3(0.0f));
  for (int32_t &vertex : both.faces)
    if (vertex == count + middle) vertex = middle;
  const Surfaced surface(shapes::triangles_of(both));
  ASSERT_EQ(surface.half_edges.nonmanifold_vertices, 1);
  expect_near_the_reference(surface, 0.3, 0.005);
}

// Edges that are longer than the ball is wide dip into it with both ends outside.
TEST(ExactPass, sees_the_boundary_beyond_edges_that_dip_into_the_ball) {
  for (const float stretch : {3.0f, 6.0f}) {
    const Surfaced surface(shapes::triangles_of(sheet(12, stretch, bowl)));
    for (const double radius : {0.3, 0.6}) {
      const CenterResults found = surface.evaluate(radius, ball_targets()[0], 1);
      EXPECT_EQ(found.boundary, surface.reference(radius).boundary) << stretch << " at " << radius;
    }
  }
}

TEST(ExactPass, has_every_triangle_and_every_point_once) {
  const Surfaced surface = torus_of(3000);
  const PointPatches &patches = surface.patches;
  const auto once = [](std::vector<int32_t> items, size_t count) {
    std::ranges::sort(items);
    bool each = items.size() == count;
    for (size_t i = 0; i < items.size(); ++i) each = each && items[i] == static_cast<int32_t>(i);
    return each;
  };
  EXPECT_TRUE(once(patches.point, static_cast<size_t>(surface.half_edges.point_count)));
  EXPECT_TRUE(once(patches.triangle, static_cast<size_t>(surface.triangles.triangle_count)));
  for (int32_t g = 0; g < patches.groups(); ++g) {
    EXPECT_LE(patches.group_begin[g + 1] - patches.group_begin[g], group_lanes);
    EXPECT_GT(patches.group_begin[g + 1], patches.group_begin[g]);
  }
}

// A regular grid of squares of side 1, halved by diagonals.
TEST(ExactChoice, knows_where_triangles_are_large_or_many) {
  Shape flat = shapes::grid(40, 40);
  for (vec3 &position : flat.positions) position.z = 0.0f;
  const Surfaced surface(shapes::triangles_of(flat));
  const TriangleSizes sizes = measure_triangles(surface.triangles, surface.half_edges, 2);
  EXPECT_NEAR(sizes.longest_edge, std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(sizes.rim_per_radius, 2.0 * (2.0 + std::sqrt(2.0)) / 0.5, 1e-4) << "twice the perimeter over the area";
  EXPECT_TRUE(suits_exact_sums({.longest_edge = 1, .rim_per_radius = 14}, 4));
  EXPECT_FALSE(suits_exact_sums({.longest_edge = 1, .rim_per_radius = 14}, 0.7)) << "a triangle is large";
  EXPECT_FALSE(suits_exact_sums({.longest_edge = 1, .rim_per_radius = 14}, 40)) << "the rim cuts many";
}

} // namespace
} // namespace paradesc::test
