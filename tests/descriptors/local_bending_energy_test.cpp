// Local bending energy, eq. (5): the mean of |n - n_i|²/|p - q_i|² over the neighborhood.
#include "support/run.h"

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class LocalBendingEnergy : public OnBackend {};
PDESC_ON_EACH_BACKEND(LocalBendingEnergy);

// |n - n_i| = |p - q_i|/R at every radius. Chords leave 0.1 % of each length: 0.2 % of a square.
TEST_P(LocalBendingEnergy, sphere_has_one_over_radius_squared_at_every_radius) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  for (const double fraction : {0.02, 0.05, 0.1})
    expect_near(compute_one(mesh, "local_bending_energy", {.radius = fraction, .normals = PDESC_NORMALS_MESH}), 0.25,
                0.25 * 2e-3);
}

// Its limit is (k1² + k2²)/2 = 2; O(r²) rest (r/R)²/8 = 0.1 %, twice 0.4 % for unevenness.
TEST_P(LocalBendingEnergy, cylinder_has_half_of_one_over_radius_squared) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "local_bending_energy", settings);
  expect_near(values, 2, 2 * 1e-2, interior(mesh, 1.1 * radius));
}

// Every summand is zero: float32 normals differ by rounding alone, squared 1e-14 over (a texel, 0.002)² = 4e-6: 4e-9.
TEST_P(LocalBendingEnergy, plane_has_none) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  expect_near(compute_one(mesh, "local_bending_energy", settings), 0, 1e-8);
}

} // namespace
} // namespace paradesc::test
