// Sphere volume V_r, eq. (6, 7): the part of the ball that lies inside the surface.
#include "support/run.h"

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};
constexpr double pi = 3.14159265358979323846;

class SphereVolume : public OnBackend {};
PDESC_ON_EACH_BACKEND(SphereVolume);

// The lens of two balls, 2 pi r³/3 - pi r⁴/(4R), less pi r² times the depth of the triangles below the sphere: at most e²/(8R) on
// average over one triangle with edges up to e.
TEST_P(SphereVolume, sphere_has_the_lens_of_two_balls) {
  TestMesh mesh = sphere(2, {.vertices = 12000});
  lay_out(mesh, {.charts = 6});
  const double e = longest_edge(mesh), depth = e * e / (8 * 2);
  for (const double fraction : {0.02, 0.06}) {
    const std::vector<float> values = compute_one(mesh, "sphere_volume", {.radius = fraction, .normals = PDESC_NORMALS_MESH});
    const double r = radius, lens = 2 * pi * r * r * r / 3 - pi * r * r * r * r / (4 * 2);
    expect_near(values, lens, pi * r * r * depth);
  }
}

// n·d is zero but for rounding, 6e-8 of r: 1e-6 of the half ball.
TEST_P(SphereVolume, plane_has_half_of_the_ball) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  const std::vector<float> values = compute_one(mesh, "sphere_volume", settings);
  const double half = 2 * pi * radius * radius * radius / 3;
  expect_near(values, half, half * 1e-6, interior(mesh, 1.1 * radius));
}

} // namespace
} // namespace paradesc::test
