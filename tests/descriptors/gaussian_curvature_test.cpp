// Gaussian curvature: K = k1 k2.
#include "support/run.h"

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class GaussianCurvature : public OnBackend {};
PDESC_ON_EACH_BACKEND(GaussianCurvature);

// No bias on a sphere; twice the 0.1 % that chords leave in each curvature.
TEST_P(GaussianCurvature, sphere_has_one_over_radius_squared) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  expect_near(compute_one(mesh, "gaussian_curvature", settings), 0.25, 0.25 * 2e-3);
}

// k2 = 0 to within 0.5 % of k1 = 2 (see its own test), times k1.
TEST_P(GaussianCurvature, cylinder_has_none) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "gaussian_curvature", settings);
  expect_near(values, mesh.K, 4 * 5e-3, interior(mesh, 1.1 * radius));
}

// Gauss-Bonnet: the integral of K over a torus is 0, over a sphere 4 pi; here as sums over vertices weighted by their share of
// area. 1 %: a vertex rule on triangles of size h leaves O(h²), the estimator 0.2 %.
TEST_P(GaussianCurvature, torus_has_no_total_curvature) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "gaussian_curvature", settings);
  double total = 0, magnitude = 0;
  for (int32_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto vertex = [&](int i) { return static_cast<size_t>(mesh.corner_vertices[static_cast<size_t>(3 * t + i)]); };
    const Vec3 p = mesh.points[vertex(0)];
    const double area = length(cross(mesh.points[vertex(1)] - p, mesh.points[vertex(2)] - p)) / 2;
    for (int i = 0; i < 3; ++i) {
      total += area / 3 * static_cast<double>(values[vertex(i)]);
      magnitude += area / 3 * std::abs(static_cast<double>(values[vertex(i)]));
    }
  }
  EXPECT_NEAR(total, 0, 0.01 * magnitude);
}

} // namespace
} // namespace paradesc::test
