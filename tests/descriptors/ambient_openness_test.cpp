// Ambient openness: V_o/(4 pi r^3/3), eq. (6).
#include "support/run.h"

#include "support/layout.h"

namespace paradesc::test {
namespace {

constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class AmbientOpenness : public OnBackend {};
PDESC_ON_EACH_BACKEND(AmbientOpenness);

// The lens of two balls: V_r = 2 pi r^3/3 - pi r^4/(4R), so that 1/2 + 3r/(16R) lies outside.
TEST_P(AmbientOpenness, sphere_has_what_the_lens_of_two_balls_leaves) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  for (const double fraction : {0.02, 0.1}) {
    const std::vector<float> values = compute_one(mesh, "ambient_openness", {.radius = fraction, .normals = PDESC_NORMALS_MESH});
    // Triangles lie below the sphere, by e²/(8R) at most on average over one with edges up to e: on pi r², as a share of the
    // ball.
    const double e = longest_edge(mesh);
    expect_near(values, 0.5 + 3 * radius / 32, 3 * (e * e / (8 * 2)) / (4 * radius));
  }
}

TEST_P(AmbientOpenness, plane_has_one_half) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  expect_near(compute_one(mesh, "ambient_openness", settings), 0.5, 1e-6);
}

// The part of the ball that is not outside is inside.
TEST_P(AmbientOpenness, is_what_the_normalized_sphere_volume_leaves) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 3000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> open = compute_one(mesh, "ambient_openness", settings);
  const std::vector<float> inside = compute_one(mesh, "sphere_volume_normalized", settings);
  for (size_t v = 0; v < open.size(); ++v) ASSERT_NEAR(open[v] + inside[v], 1.0f, 1e-6f) << "vertex " << v;
}

} // namespace
} // namespace paradesc::test
