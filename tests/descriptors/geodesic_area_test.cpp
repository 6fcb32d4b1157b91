// Geodesic area, eq. (11) to (14): the area of the surface within the radius along it.
#include "support/run.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/layout.h"

namespace paradesc::test {
namespace {

class GeodesicArea : public OnBackend {};
PDESC_ON_EACH_BACKEND(GeodesicArea);

// A geodesic disk on a sphere of radius R has 2 pi R^2 (1 - cos(r/R)). The chords of 6000 vertices leave 0.1 %. It differs
// from the area in the ball by (r/R)^2/12: 0.8 % at the larger radius, ten times the tolerance.
TEST_P(GeodesicArea, sphere_has_that_of_the_cap) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  for (const double fraction : {0.04, 0.1}) {
    const std::vector<float> values = compute_one(mesh, "geodesic_area", {.radius = fraction});
    const double cap = 2 * std::numbers::pi * 4 * (1 - std::cos(radius / 2));
    // A single vertex of texture space has the noise of its samples' rim, a hundredth of what plain counting has.
    expect_near(values, cap, cap * (GetParam() == PDESC_BACKEND_REFERENCE ? 1e-3 : 4e-3));
    double mean = 0;
    for (const float value : values) mean += static_cast<double>(value) / static_cast<double>(values.size());
    EXPECT_NEAR(mean, cap, cap * 1e-3) << "r " << radius;
  }
}

// A cylinder can be unrolled: the disk, at any radius. Samples that march leave gaps and overlaps where seams bend, so in texture
// space the mean over vertices has it.
TEST_P(GeodesicArea, cylinder_has_that_of_the_disk) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "geodesic_area", {.radius = 0.08});
  const double disk = std::numbers::pi * radius * radius;
  const std::vector<uint8_t> inside = interior(mesh, 1.1 * radius);
  if (GetParam() == device_backend()) {
    double sum = 0;
    for (size_t v = 0; v < values.size(); ++v) sum += inside[v] ? static_cast<double>(values[v]) : 0;
    EXPECT_NEAR(sum / static_cast<double>(std::ranges::count(inside, 1)), disk, disk * 1e-3);
    return;
  }
  expect_near(values, disk, disk * (GetParam() == PDESC_BACKEND_REFERENCE ? 1e-3 : 4e-3), inside);
}

// The ball just holds the tube, so planes of the far side's triangles cut it in small disks, or not at all.
TEST_P(GeodesicArea, of_a_tube_that_just_fits_into_the_ball_is_most_of_the_area_in_the_ball) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> along = compute_one(mesh, "geodesic_area", {.radius = 0.19});
  const std::vector<float> within = compute_one(mesh, "euclidean_area", {.radius = 0.19});
  // Texture space, which asks for the distance of each sample, has 0.86 or more. Triangles measure the strip beyond the radius at
  // the rim, and have 0.82 or more. With strips that are larger than their disks it was 0.64.
  for (size_t v = 0; v < along.size(); ++v) EXPECT_GT(along[v], 0.78f * within[v]) << v;
}

} // namespace
} // namespace paradesc::test
