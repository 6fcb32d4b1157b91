// Mean curvature: H = (k1 + k2)/2.
#include "support/run.h"

#include "support/layout.h"
#include "support/percent_ae.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class MeanCurvature : public OnBackend {};
PDESC_ON_EACH_BACKEND(MeanCurvature);

// On a sphere n - n_i = -(q - p)/R at every radius: no bias. Chords of 0.06 leave up to (0.06)²/4, 0.1 %.
TEST_P(MeanCurvature, sphere_has_mean_curvature_one_over_radius) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  expect_near(compute_one(mesh, "mean_curvature", settings), 0.5, 0.5 * 1e-3);
}

// Wound the other way the inside is outside. The same chords, the same 0.1 %.
TEST_P(MeanCurvature, sphere_turned_inside_out_has_the_negative) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  turn_inside_out(mesh);
  lay_out(mesh, {.charts = 6});
  expect_near(compute_one(mesh, "mean_curvature", settings), -0.5, 0.5 * 1e-3);
}

// Away from the ends; bias of a finite neighborhood (r/R)²/8 = 0.1 %, and 0.4 % for the pattern's and the texels' unevenness.
TEST_P(MeanCurvature, cylinder_has_half_of_one_over_radius) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "mean_curvature", settings);
  expect_near(values, mesh.H, 5e-3, interior(mesh, 1.1 * radius));
}

// The bias of a ball grows with r^2. Two windows on the same samples take that term away, and what is left grows with r^4.
TEST_P(MeanCurvature, extrapolation_takes_the_bias_of_large_radii_away) {
  if (GetParam() == device_backend()) GTEST_SKIP() << "the noise of samples that march is more than what is left of the bias";
  TestMesh mesh = ellipsoid(1, 0.75, 0.5, {.vertices = 4000});
  lay_out(mesh, {.charts = 6});
  const auto error = [&](int32_t estimator) {
    const std::vector<float> values = compute_one(mesh, "mean_curvature", {.radius = 0.12, .estimator = estimator});
    return percent_ae(values, mesh.H).mean;
  };
  const double fitted = error(PDESC_ESTIMATOR_SHAPE_OPERATOR), extrapolated = error(PDESC_ESTIMATOR_EXTRAPOLATED);
  EXPECT_GT(fitted, 2);
  EXPECT_LT(extrapolated, 0.15 * fitted);
}

} // namespace
} // namespace paradesc::test
