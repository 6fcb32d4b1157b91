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

// A ribbon of a twentieth of the radius, on which no quadratic is determined, bent along its length.
TestMesh thin_ribbon() {
  TestMesh mesh = plane(2, 0.02, {.vertices = 600});
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    const double x = mesh.points[v].x;
    mesh.points[v].z = 0.2 * std::sin(3 * x);
    mesh.normals[v] = normalized({-0.6 * std::cos(3 * x), 0, 1});
  }
  round_to_float(mesh);
  lay_out(mesh, {.charts = 1});
  return mesh;
}

// Its windows need the map alone. Beside Harris' gradient, which is undefined here, it once left out what had none.
TEST_P(DifferenceOfGaussians, exists_where_the_gradient_does_not) {
  const TestMesh mesh = thin_ribbon();
  Settings requested = settings;
  requested.radius = 0.1;
  requested.buffer_size = 512;
  requested.samples = GetParam() == device_backend() ? 1024 : 64; // of a pattern most lie beside the ribbon
  const std::vector<std::string> both{"difference_of_gaussians", "harris", "gradient_magnitude"};
  const std::vector<float> alone = compute_one(mesh, both[0], requested);
  const Results together = compute(context.get(), mesh, requested, both);
  size_t undefined = 0;
  for (const float value : together["gradient_magnitude"]) undefined += std::isnan(value);
  EXPECT_GT(undefined, alone.size() / 2) << "the ribbon is too wide to say anything";
  const std::vector<double> expected(alone.begin(), alone.end());
  expect_near(together[both[0]], expected, 1e-5 * largest(expected)); // another program of the same sums
}

} // namespace
} // namespace paradesc::test
