// Curvedness: sqrt((k1² + k2²)/2).
#include "support/run.h"

#include <cmath>

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class Curvedness : public OnBackend {};
PDESC_ON_EACH_BACKEND(Curvedness);

// No bias on a sphere; chords leave 0.1 %.
TEST_P(Curvedness, sphere_has_one_over_radius) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  expect_near(compute_one(mesh, "curvedness", settings), 0.5, 0.5 * 1e-3);
}

// k1/sqrt(2): as k1, 0.5 %.
TEST_P(Curvedness, cylinder_has_one_over_radius_and_root_two) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "curvedness", settings);
  expect_near(values, std::sqrt(2.0), std::sqrt(2.0) * 5e-3, interior(mesh, 1.1 * radius));
}

// Rounding of float32 positions of size 1 over r = 0.045: 1.5e-6 in a normal's turn at most, which over r is 3e-5.
TEST_P(Curvedness, plane_has_none) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  expect_near(compute_one(mesh, "curvedness", settings), 0, 3e-5);
}

} // namespace
} // namespace paradesc::test
