// 16-bit buffers against those of 32 bits, as what is computed from them sees them: positions and normals of texels with what
// rounding left, where tests of the buffers themselves read back what the device stored.
#include <algorithm>
#include <cmath>

#include "support/layout.h"
#include "support/percent_ae.h"
#include "support/run.h"

namespace paradesc::test {
namespace {

class HalfPrecision : public ::testing::TestWithParam<int32_t> {
protected:
  void SetUp() override {
    std::string why_not;
    context = open_context(device_backend(), why_not);
    if (!context) GTEST_SKIP() << why_not;
    names = registered_descriptors();
    std::erase_if(names, [](const std::string &name) { return components_of(name) != 1 || map_degree_of(name) > 0; });
  }
  Context context;
  std::vector<std::string> names;
};
INSTANTIATE_TEST_SUITE_P(, HalfPrecision, ::testing::Values(int32_t{PDESC_RELOCATION_AFFINE}, int32_t{PDESC_RELOCATION_PAPER}));

// At 1 % of the diagonal 11 bits of a position are a twentieth of the radius, and what they leave is needed; 16 bits are 0.1 % of
// it.
TEST_P(HalfPrecision, hardly_changes_any_descriptor_at_any_vertex) {
  TestMesh mesh = ellipsoid(1, 0.75, 0.5, {.vertices = 3000});
  lay_out(mesh, {.charts = 15});
  Settings settings{.radius = 0.01, .relocation = GetParam()};
  const Results full = compute(context.get(), mesh, settings, names);
  settings.precision = PDESC_PRECISION_HALF;
  const Results half = compute(context.get(), mesh, settings, names);
  ASSERT_EQ(half.report.buffer_megabytes, full.report.buffer_megabytes * 2 / 3) << "it is another precision";
  for (const std::string &name : names) {
    if (name.ends_with("_area")) { // whose range is that of a few samples on the rim, which are in or out
      for (size_t v = 0; v < mesh.points.size(); ++v) ASSERT_NEAR(half[name][v], full[name][v], 0.01 * full[name][v]) << name;
      continue;
    }
    const PercentAe error = percent_ae(half[name], as_double(full[name]), {}, 1);
    // Measured: 0.035 % at one vertex in a hundred, 0.14 % at the worst; volumes, which heights of 1e-4 of the radius make, 0.34
    // and 0.62 %.
    const bool volume = name.starts_with("sphere_volume") || name == "ambient_openness";
    EXPECT_LT(error.p99, volume ? 0.6 : 0.07) << name;
    EXPECT_LT(error.max, volume ? 1.2 : 0.3) << name;
  }
  EXPECT_EQ(half.mask, full.mask);
}

} // namespace
} // namespace paradesc::test
