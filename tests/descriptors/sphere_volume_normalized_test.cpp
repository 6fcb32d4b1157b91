// Sphere volume as a share of the ball, eq. (7).
#include "support/run.h"

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class SphereVolumeNormalized : public OnBackend {};
PDESC_ON_EACH_BACKEND(SphereVolumeNormalized);

// Triangles lie below the sphere, by e²/(8R) at most on average over one with edges up to e: on pi r², as a share of the ball.
double tolerance(const TestMesh &mesh, double r) {
  const double e = longest_edge(mesh);
  return 3 * (e * e / (8 * 2)) / (4 * r);
}

// 1/2 - 3r/(16R): the lens of two balls.
TEST_P(SphereVolumeNormalized, sphere_has_half_less_three_sixteenths_of_r_over_radius) {
  TestMesh mesh = sphere(2, {.vertices = 12000});
  lay_out(mesh, {.charts = 6});
  for (const double fraction : {0.02, 0.06}) {
    const std::vector<float> values =
        compute_one(mesh, "sphere_volume_normalized", {.radius = fraction, .normals = PDESC_NORMALS_MESH});
    expect_near(values, 0.5 - 3 * radius / (16 * 2), tolerance(mesh, radius));
  }
}

// Inside and outside share the ball.
TEST_P(SphereVolumeNormalized, sphere_turned_inside_out_has_the_rest) {
  TestMesh mesh = sphere(2, {.vertices = 12000});
  turn_inside_out(mesh);
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "sphere_volume_normalized", settings);
  expect_near(values, 0.5 + 3 * radius / (16 * 2), tolerance(mesh, radius));
}

// Rounding: 1e-6 of the half ball.
TEST_P(SphereVolumeNormalized, plane_has_one_half) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  const std::vector<float> values = compute_one(mesh, "sphere_volume_normalized", settings);
  expect_near(values, 0.5, 5e-7, interior(mesh, 1.1 * radius));
}

} // namespace
} // namespace paradesc::test
