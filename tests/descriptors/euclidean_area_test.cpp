// Euclidean area, eq. (13): the area of the surface within the ball.
#include "support/run.h"

#include <cmath>

#include "support/layout.h"
#include "support/percent_ae.h"

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;

class EuclideanArea : public OnBackend {
protected:
  // The oracle clips triangles exactly; chords leave 0.1 %. In texture space 57 of 256 samples lie on the rim, a cell (r/9) wide,
  // and count by their distance to it, which rounding to a texel (r/9 too) blurs by 0.3 of a cell: deviation 0.3 sqrt(57)/256 =
  // 0.9 %. Five of those.
  double tolerance() const { return GetParam() == PDESC_BACKEND_REFERENCE ? 2e-3 : 4.5e-2; }

  // That noise has no sign. 0.2 % for the chords; 1 % of 300 vertices' 0.9 % is nothing beside it.
  static void expect_no_bias(std::span<const float> values, double expected, std::span<const uint8_t> subset) {
    double mean = 0, count = 0;
    for (size_t v = 0; v < values.size(); ++v) {
      if (!subset[v]) continue;
      mean += static_cast<double>(values[v]);
      ++count;
    }
    EXPECT_GE(count, 300);
    EXPECT_NEAR(mean / count, expected, 2e-3 * expected);
  }
};
PDESC_ON_EACH_BACKEND(EuclideanArea);

TEST_P(EuclideanArea, plane_has_that_of_the_disk) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  const std::vector<float> values = compute_one(mesh, "euclidean_area", {});
  const double disk = pi * radius * radius;
  expect_near(values, disk, disk * tolerance(), interior(mesh, 1.1 * radius));
}

// Archimedes: a ball around a point of a sphere cuts a cap of area pi r² from it, whatever its radius.
TEST_P(EuclideanArea, sphere_has_that_of_the_disk_at_every_radius) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  for (const double fraction : {0.02, 0.1}) {
    const std::vector<float> values = compute_one(mesh, "euclidean_area", {.radius = fraction});
    expect_near(values, pi * radius * radius, pi * radius * radius * tolerance());
  }
}

TEST_P(EuclideanArea, nothing_is_lost_or_gained_on_average_at_seams_and_away_from_them) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  for (const double fraction : {0.02, 0.1}) {
    const std::vector<float> values = compute_one(mesh, "euclidean_area", {.radius = fraction});
    const std::vector<uint8_t> seam = near_seam(mesh, radius), inside = without(std::vector<uint8_t>(seam.size(), 1), seam);
    expect_no_bias(values, pi * radius * radius, seam);
    expect_no_bias(values, pi * radius * radius, inside);
  }
}

// A straight border through the middle leaves half; the mask says so.
TEST_P(EuclideanArea, plane_has_half_of_the_disk_at_a_straight_boundary) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  const std::vector<float> values = compute_one(mesh, "euclidean_area", {});
  std::vector<uint8_t> border;
  for (const Vec3 p : mesh.points) border.push_back(std::abs(std::abs(p.x) - 1) < 1e-9 && std::abs(p.y) < 0.5 - 1.1 * radius);
  const double half = pi * radius * radius / 2;
  expect_near(values, half, half * tolerance(), border);
}

} // namespace
} // namespace paradesc::test
