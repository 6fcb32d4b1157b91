// Laplace-Beltrami of a map f.
#include "support/run.h"

#include "support/layout.h"
#include "support/percent_ae.h"
#include "support/torus_map.h"

namespace paradesc::test {
namespace {

constexpr Settings settings{.radius = 0.03, .normals = PDESC_NORMALS_MESH, .map_descriptor = "mean_curvature"};

class Laplacian : public OnBackend {};
PDESC_ON_EACH_BACKEND(Laplacian);

TEST_P(Laplacian, of_the_mean_curvature_of_a_torus_is_that_of_the_closed_form) {
  TorusMap map = torus_map(1, 0.5, {.vertices = 12000});
  lay_out(map.mesh, {.charts = 15});
  const std::vector<float> values = compute_one(map.mesh, "laplacian", settings);
  const PercentAe error = percent_ae(values, map.laplacian);
  std::cout << "%AE mean " << error.mean << " max " << error.max << "\n";
  // 1 % for the finite disk (twice: H, and its quadratic), as much again for samples.
  EXPECT_LE(error.mean, 2);
}

} // namespace
} // namespace paradesc::test
