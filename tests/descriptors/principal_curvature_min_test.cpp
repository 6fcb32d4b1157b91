// The smaller principal curvature: k2.
#include "support/run.h"

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class PrincipalCurvatureMin : public OnBackend {};
PDESC_ON_EACH_BACKEND(PrincipalCurvatureMin);

// Straight lines: 0 to within 0.5 % of k1 = 2, for the pattern's and the texels' unevenness.
TEST_P(PrincipalCurvatureMin, cylinder_has_none) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "principal_curvature_min", settings);
  expect_near(values, 0, 2 * 5e-3, interior(mesh, 1.1 * radius));
}

// cos v/(R + r cos v), from 0.71 outside to -1.67 inside; 1 % of k1 = 2.5, as for k1.
TEST_P(PrincipalCurvatureMin, torus_has_its_closed_form) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 10000});
  lay_out(mesh, {.charts = 6});
  expect_near(compute_one(mesh, "principal_curvature_min", settings), mesh.k2, 2.5 * 1e-2);
}

} // namespace
} // namespace paradesc::test
