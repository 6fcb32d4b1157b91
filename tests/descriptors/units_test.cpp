// Meshes so small that a curvature in their units is more than a float holds.
#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "descriptor/results.h"
#include "support/layout.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

TEST(Units, keep_zero_and_all_that_a_float_holds) {
  EXPECT_EQ(in_unit(0.0f, 1e40), 0.0f);
  EXPECT_FLOAT_EQ(in_unit(1e-10f, 1e40), 1e30f);
  EXPECT_EQ(in_unit(1e-10f, 1e-60), 0.0f);
  EXPECT_EQ(in_unit(3.0f, 1.0 / 3.0), 3.0f * static_cast<float>(1.0 / 3.0)) << "in floats, as ever";
  EXPECT_TRUE(std::isnan(in_unit(std::nanf(""), 1e40)));
}

class TinyMesh : public OnBackend {};
PDESC_ON_EACH_BACKEND(TinyMesh);

TEST_P(TinyMesh, that_is_flat_has_no_curvature) {
  TestMesh mesh = plane(1, 1, {.vertices = 400});
  lay_out(mesh, {.charts = 1});
  for (Vec3 &point : mesh.points) point = 1e-20 * point;
  round_to_float(mesh);
  // A card fuses sums, so that normals that are equal differ by rounding.
  const double rounding = GetParam() == PDESC_BACKEND_GPU ? 1e-12 : 0.0, ball = 0.1 * std::sqrt(2.0) * 1e-20;
  for (const auto &[name, unit] : {std::pair("mean_curvature", 1 / ball), std::pair("gaussian_curvature", 1 / (ball * ball)),
                                   std::pair("local_bending_energy", 1 / (ball * ball))})
    for (const float value : compute_one(mesh, name, {.radius = 0.1, .buffer_size = 256}))
      ASSERT_LE(std::abs(static_cast<double>(value)), rounding * unit) << name;
}

} // namespace
} // namespace paradesc::test
