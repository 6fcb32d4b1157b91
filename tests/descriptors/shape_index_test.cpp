// Shape index: (2/pi) atan2(k1 + k2, k1 - k2), convex positive.
#include "support/run.h"

#include <cmath>

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class ShapeIndex : public OnBackend {};
PDESC_ON_EACH_BACKEND(ShapeIndex);

// 1 - (2/pi) (k1 - k2)/(k1 + k2) to first order, and k1 - k2 is 0.2 % of k1 + k2 by the chords.
TEST_P(ShapeIndex, sphere_is_a_cap) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  expect_near(compute_one(mesh, "shape_index", settings), 1, 2e-3);
}

TEST_P(ShapeIndex, sphere_turned_inside_out_is_a_cup) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  turn_inside_out(mesh);
  lay_out(mesh, {.charts = 6});
  expect_near(compute_one(mesh, "shape_index", settings), -1, 2e-3);
}

// Around k2 = 0 it changes by (2/pi) k2/k1, and k2 is within 0.5 % of k1 of zero.
TEST_P(ShapeIndex, cylinder_is_a_ridge) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "shape_index", settings);
  expect_near(values, 0.5, 5e-3, interior(mesh, 1.1 * radius));
}

// k1 = -k2, each within 1 % (the rims have the torus' bias; the neck more: (r/0.5)² = 0.6 %).
TEST_P(ShapeIndex, catenoid_is_a_saddle) {
  TestMesh mesh = catenoid(0.5, 0.6, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "shape_index", settings);
  expect_near(values, 0, 1e-2, interior(mesh, 1.1 * radius));
}

TEST_P(ShapeIndex, plane_has_none) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  for (const float value : compute_one(mesh, "shape_index", settings)) ASSERT_TRUE(std::isnan(value)) << value;
}

} // namespace
} // namespace paradesc::test
