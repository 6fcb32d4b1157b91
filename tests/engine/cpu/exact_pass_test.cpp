// Sums over all triangles in a ball: the same bits by every set of instructions and any number of threads, and the reference's
// values and boundary flags, also where several parts of a surface lie in one ball.
#include "engine/cpu/exact_pass.h"

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

ExactSurface torus_of(int vertices) { return ExactSurface(read_triangles(input_of(torus(1.0, 0.4, {.vertices = vertices})))); }

TEST(ExactPass, has_the_same_bits_by_every_set_of_instructions_and_any_number_of_threads) {
  const ExactSurface surface = torus_of(3000);
  for (const ExactSetting &setting : both_ways()) expect_the_same_bits_everywhere(surface, 0.2, setting);
}

// Shares of the largest value, by row: as measured where triangles are half as large as the radius, and where they are a quarter.
// Arcs are series, and normals are linear on triangles or parts of them, while those of the reference have length 1 everywhere.
// One by one, triangles have one mean direction each, and the strip between the two areas is small.
TEST(ExactPass, has_the_values_of_the_reference) {
  const ExactSurface surface = torus_of(3000);
  expect_near_the_reference(surface, 0.13, by_moments(), {0.002, 0.002, 0.01});
  expect_near_the_reference(surface, 0.3, by_moments(), {0.0003, 0.0003, 0.001});
  expect_near_the_reference(surface, 0.13, one_by_one(), {0.005, 0.015, 0.05, 0.003});
  expect_near_the_reference(surface, 0.3, one_by_one(), {0.001, 0.003, 0.005, 0.0015});
}

// Shares of the largest value on sheets, which bend less than the torus. Their triangles are a quarter of the radius long.
const std::vector<double> of_sheets{0.001, 0.002, 0.005, 0.001};

TEST(ExactPass, has_the_values_of_the_reference_beside_open_borders) {
  const ExactSurface surface(shapes::triangles_of(sheet(24, 1.0f, bowl)));
  for (const ExactSetting &setting : both_ways()) expect_near_the_reference(surface, 0.3, setting, of_sheets);
}

// A bent ribbon, which is 1/200 as wide as the ball and does not lie along an axis.
TEST(ExactPass, has_the_values_of_the_reference_on_a_thin_ribbon) {
  Shape ribbon;
  constexpr int length = 200, width = 2;
  for (int i = 0; i <= length; ++i)
    for (int k = 0; k <= width; ++k) {
      const float along = static_cast<float>(i) / static_cast<float>(length), across = 0.0005f * static_cast<float>(k);
      const float bend = 0.1f * std::cos(8.0f * along);
      ribbon.positions.emplace_back(0.8f * along - 0.6f * across, 0.6f * along + 0.8f * across, bend + 0.3f * across);
    }
  for (int i = 0; i < length; ++i)
    for (int k = 0; k < width; ++k) {
      const int32_t a = i * (width + 1) + k, b = a + width + 1;
      ribbon.faces.insert(ribbon.faces.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
  expect_near_the_reference(ExactSurface(shapes::triangles_of(ribbon)), 0.1, by_moments(), {0.02, 0.02, 0.02});
}

// Values and flags are those at points, although the search begins with the corners of a triangle.
TEST(ExactPass, has_the_same_values_at_centers_that_are_not_points) {
  const ExactSurface surface(shapes::triangles_of(sheet(24, 1.0f, bowl)));
  for (const ExactSetting &setting : both_ways()) expect_the_same_from_triangles(surface, 0.3, setting);
}

// Both sheets lie in each other's balls, and are curved differently.
TEST(ExactPass, leaves_out_what_is_not_connected_in_the_ball) {
  const ExactSurface surface(shapes::triangles_of(shapes::join(sheet(24, 1.0f, bowl), sheet(24, 1.0f, dome, 0.05f))));
  ASSERT_EQ(surface.half_edges.components, 2);
  for (const ExactSetting &setting : both_ways()) expect_near_the_reference(surface, 0.3, setting, of_sheets);
}

// Two sheets that share the vertex in their middles, which has a point for each.
TEST(ExactPass, keeps_sheets_apart_that_touch_at_a_vertex) {
  const Shape above = sheet(24, 1.0f, bowl);
  Shape both = shapes::join(above, sheet(24, 1.0f, dome));
  const auto count = static_cast<int32_t>(above.positions.size()), middle = count / 2;
  ASSERT_EQ(above.positions[static_cast<size_t>(middle)], vec3(0.0f));
  for (int32_t &vertex : both.faces)
    if (vertex == count + middle) vertex = middle;
  const ExactSurface surface(shapes::triangles_of(both));
  ASSERT_EQ(surface.half_edges.nonmanifold_vertices, 1);
  for (const ExactSetting &setting : both_ways()) expect_near_the_reference(surface, 0.3, setting, of_sheets);
}

// Edges that are longer than the ball is wide dip into it with both ends outside.
TEST(ExactPass, sees_the_boundary_beyond_edges_that_dip_into_the_ball) {
  for (const float stretch : {3.0f, 6.0f}) {
    const ExactSurface surface(shapes::triangles_of(sheet(12, stretch, bowl)));
    for (const ExactSetting &setting : both_ways())
      for (const double radius : {0.3, 0.6})
        EXPECT_EQ(surface.evaluate(radius, setting).boundary, surface.reference(radius, setting.rows).boundary)
            << stretch << " at " << radius;
  }
}

} // namespace
} // namespace paradesc::test
