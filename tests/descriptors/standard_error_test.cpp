// The standard error of H by noise: how often it covers what noise changes, and where it is nothing or unknown.
#include <cmath>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

class StandardError : public OnBackend {
protected:
  void SetUp() override {
    OnBackend::SetUp();
    mesh = torus(1, 0.4, {.vertices = 5000});
    lay_out(mesh, {.charts = 1});
  }
  bool is_device() const { return GetParam() != PDESC_BACKEND_REFERENCE && GetParam() != PDESC_BACKEND_CPU; }

  TestMesh mesh;
};
PDESC_ON_EACH_BACKEND(StandardError);

// Moves every vertex along each axis by a deviate of so many lengths.
TestMesh noisy(TestMesh mesh, double deviation) {
  Random random(1);
  for (Vec3 &point : mesh.points) point = point + deviation * Vec3{random.normal(), random.normal(), random.normal()};
  round_to_float(mesh);
  return mesh;
}

// 95 % are wanted. Normals of rough places and of smooth ones blur by different amounts, for which there is room.
TEST_P(StandardError, covers_what_noise_changes) {
  if (is_device()) GTEST_SKIP() << "Texels do not know the noise of positions.";
  for (const double share_of_diagonal : {0.04, 0.08}) {
    const Settings settings{.radius = share_of_diagonal};
    const std::vector<float> before = compute_one(mesh, "mean_curvature", settings);
    const double edge = 0.047; // the mean one
    for (const double share : {0.05, 0.2}) {
      const TestMesh moved = noisy(mesh, share * edge);
      const std::vector<float> after = compute_one(moved, "mean_curvature", settings),
                               error = compute_one(moved, "standard_error", settings);
      size_t covered = 0;
      for (size_t i = 0; i < after.size(); ++i) covered += std::abs(after[i] - before[i]) < 1.96f * error[i];
      const double percent = 100.0 * static_cast<double>(covered) / static_cast<double>(after.size());
      EXPECT_GT(percent, 88) << share_of_diagonal << ", " << share;
      EXPECT_LT(percent, 99.9) << share_of_diagonal << ", " << share;
    }
  }
}

// Smooth vertices lie on cubic jets but for what these leave out: a thousandth of H here.
TEST_P(StandardError, of_a_smooth_surface_is_small) {
  if (is_device()) GTEST_SKIP() << "Texels do not know the noise of positions.";
  for (const float value : compute_one(mesh, "standard_error", {.radius = 0.06})) EXPECT_LT(value, 0.01f);
}

TEST_P(StandardError, is_unknown_where_no_normals_are_fitted) {
  Settings settings{.radius = 0.06};
  settings.normals = is_device() ? PDESC_NORMALS_FITTED : PDESC_NORMALS_MESH;
  for (const float value : compute_one(mesh, "standard_error", settings)) ASSERT_TRUE(std::isnan(value));
}

} // namespace
} // namespace paradesc::test
