// Euclidean area, eq. (13): the area of the surface within the ball.
#include "support/run.h"

#include <cmath>

#include "support/layout.h"

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;

class EuclideanArea : public OnBackend {
protected:
  // The oracle clips triangles exactly. 256 samples of texture space divide the rim's 57 cells by their distance to it: 2 % at a
  // vertex.
  double tolerance() const { return GetParam() == PDESC_BACKEND_REFERENCE ? 2e-3 : 2e-2; }
};
PDESC_ON_EACH_BACKEND(EuclideanArea);

TEST_P(EuclideanArea, plane_has_that_of_the_disk) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  const std::vector<float> values = compute_one(mesh, "euclidean_area", {});
  const double disk = pi * radius * radius;
  expect_near(values, disk, disk * tolerance(), interior(mesh, 1.1 * radius));
}

// Archimedes: a ball around a point of a sphere cuts a cap of area pi r² from it, whatever its radius. Chords leave 0.1 %.
TEST_P(EuclideanArea, sphere_has_that_of_the_disk_at_every_radius) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  for (const double fraction : {0.02, 0.1}) {
    const std::vector<float> values = compute_one(mesh, "euclidean_area", {.radius = fraction});
    const double disk = pi * radius * radius;
    expect_near(values, disk, disk * tolerance());
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
  expect_near(values, half, 2 * half * tolerance(), border);
}

} // namespace
} // namespace paradesc::test
