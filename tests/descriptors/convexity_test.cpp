// Convexity: the convex part of H r.
#include "support/run.h"

#include "support/layout.h"

namespace paradesc::test {
namespace {

constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class Convexity : public OnBackend {};
PDESC_ON_EACH_BACKEND(Convexity);

TEST_P(Convexity, sphere_seen_from_inside_has_none) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  turn_inside_out(mesh);
  expect_near(compute_one(mesh, "convexity", settings), 0.0, 0.0);
}

// Chords leave 0.1 % of H.
TEST_P(Convexity, sphere_seen_from_outside_has_radius_over_radius) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> values = compute_one(mesh, "convexity", settings);
  expect_near(values, radius / 2, radius / 2 * 2e-3);
}

TEST_P(Convexity, plane_has_none) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  expect_near(compute_one(mesh, "convexity", settings), 0.0, 1e-6);
}

} // namespace
} // namespace paradesc::test
