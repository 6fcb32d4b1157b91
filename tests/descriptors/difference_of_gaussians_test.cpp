// The mean of a map f in a window of sigma/1.6 less that in one of sigma.
#include "support/run.h"

#include "support/layout.h"
#include "support/percent_ae.h"
#include "support/torus_map.h"

namespace paradesc::test {
namespace {

constexpr Settings settings{.normals = PDESC_NORMALS_MESH, .map_descriptor = "mean_curvature"};

class DifferenceOfGaussians : public OnBackend {};
PDESC_ON_EACH_BACKEND(DifferenceOfGaussians);

// Mean of |x|^2 over a Gaussian of sigma that ends at reach.
double spread(double sigma, double reach) {
  const double t = reach * reach / (2 * sigma * sigma);
  return 2 * sigma * sigma * (1 - t * std::exp(-t) / (1 - std::exp(-t)));
}

// A mean is f + Laplacian/4 times the mean of |x|^2, but for the fourth derivatives.
TEST_P(DifferenceOfGaussians, follows_the_laplacian) {
  TorusMap map = torus_map(1, 0.5, {.vertices = 12000});
  lay_out(map.mesh, {.charts = 15});
  const std::vector<float> values = compute_one(map.mesh, "difference_of_gaussians", settings);
  std::vector<double> expected;
  for (const double value : map.laplacian)
    expected.push_back(0.25 * value * (spread(radius / 1.6, 2 * radius) - spread(radius, 2 * radius)));
  const PercentAe error = percent_ae(values, expected);
  std::cout << "%AE mean " << error.mean << " max " << error.max << "\n";
  // 1 % for fourth derivatives, as much again for samples.
  EXPECT_LE(error.mean, 2);
}

} // namespace
} // namespace paradesc::test
