// |grad f| of a map f.
#include "support/run.h"

#include "support/layout.h"
#include "support/torus_map.h"

namespace paradesc::test {
namespace {

constexpr Settings settings{.normals = PDESC_NORMALS_MESH, .map_descriptor = "mean_curvature"};

class GradientMagnitude : public OnBackend {};
PDESC_ON_EACH_BACKEND(GradientMagnitude);

TEST_P(GradientMagnitude, of_the_mean_curvature_of_a_torus_is_its_slope) {
  TorusMap map = torus_map(1, 0.6, {.vertices = 12000});
  lay_out(map.mesh, {.charts = 15});
  const std::vector<float> values = compute_one(map.mesh, "gradient_magnitude", settings);
  // H is the mean over a disk, and so is its slope: (r/L)^2 = 4 % each where H bends most, at the hole.
  expect_near(values, map.slope, 0.06 * largest(map.slope));
}

// A sphere has no slope. H is exact there but for chords, 0.1 % of 1/R, over r.
TEST_P(GradientMagnitude, of_the_mean_curvature_of_a_sphere_is_zero) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "gradient_magnitude", settings);
  expect_near(values, 0, 1e-3 * 0.5 / radius);
}

// A plane has no shape index; a map that does not exist has no slope.
TEST_P(GradientMagnitude, of_a_map_that_exists_nowhere_is_undefined) {
  TestMesh mesh = plane(1, 1, {.vertices = 400});
  lay_out(mesh, {});
  for (const char *name : {"gradient_magnitude", "laplacian", "difference_of_gaussians", "harris"})
    for (const float value : compute_one(mesh, name, {.radius = 0.1, .buffer_size = 256, .map_descriptor = "shape_index"}))
      ASSERT_TRUE(std::isnan(value)) << name;
}

} // namespace
} // namespace paradesc::test
