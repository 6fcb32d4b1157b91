// Roughness: the root mean square of |n_i - n(x)|, n(x) the normal that the shape operator says.
#include "support/run.h"

#include <cmath>

#include "support/layout.h"

namespace paradesc::test {
namespace {

// Exact corner normals, so that the estimator alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class Roughness : public OnBackend {};
PDESC_ON_EACH_BACKEND(Roughness);

// The tangents of a sphere's normals are linear in positions, and what is left is how much their heights vary:
// (r/R)^2/(4 sqrt(3)) of a cap, 7e-5 with r = 0.022 R.
TEST_P(Roughness, a_sphere_is_hardly_rough) {
  TestMesh mesh = sphere(2, {.vertices = 6000});
  lay_out(mesh, {.charts = 6});
  for (const float value : compute_one(mesh, "roughness", settings)) EXPECT_LT(value, 2e-3);
}

// Normals that turn by random angles of 0.1 are 0.1 sqrt(2) from those that a plane has, but for what is linear over the few dozens of
// corners in a ball, and for what interpolation over triangles takes away: a half of the variance.
TEST_P(Roughness, normals_of_noise_are_rough) {
  TestMesh mesh = plane(2, 1, {.vertices = 1000});
  lay_out(mesh, {.charts = 1});
  Random random(1);
  for (Vec3 &n : mesh.normals) n = normalized({0.1 * random.normal(), 0.1 * random.normal(), 1});
  round_to_float(mesh);
  const std::vector<float> values = compute_one(mesh, "roughness", settings);
  double sum = 0;
  for (const float value : values) sum += value;
  EXPECT_NEAR(sum / static_cast<double>(values.size()), 0.09, 0.02);
}

} // namespace
} // namespace paradesc::test
