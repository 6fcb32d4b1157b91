// The larger principal curvature: k1.
#include "support/run.h"

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class PrincipalCurvatureMax : public OnBackend {};
PDESC_ON_EACH_BACKEND(PrincipalCurvatureMax);

// Bias of a finite neighborhood (r/R)²/8 = 0.1 %, and 0.4 % for the pattern's and the texels' unevenness.
TEST_P(PrincipalCurvatureMax, cylinder_has_one_over_radius) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "principal_curvature_max", settings);
  expect_near(values, mesh.k1, 2 * 5e-3, interior(mesh, 1.1 * radius));
}

// The tube's bias is (r/0.4)²/8 at r = 0.08: 0.5 %; as much again for the rest.
TEST_P(PrincipalCurvatureMax, torus_has_that_of_its_tube_everywhere) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 10000});
  lay_out(mesh, {.charts = 6});
  expect_near(compute_one(mesh, "principal_curvature_max", settings), 2.5, 2.5 * 1e-2);
}

} // namespace
} // namespace paradesc::test
