// Which passes operators need, and what they hand on.
#include "descriptor/passes.h"

#include <gtest/gtest.h>

#include "descriptor/registry.h"

namespace paradesc::test {
namespace {

int row(const char *name) { return find_descriptor(name); }

TEST(Passes, descriptors_of_the_surface_take_one) {
  const std::vector<int> requested{row("mean_curvature"), row("shape_index")};
  const std::vector<Pass> passes = plan_passes(requested, row("sphere_volume"));
  ASSERT_EQ(passes.size(), 1u);
  EXPECT_EQ(passes[0].rows, requested);
}

TEST(Passes, an_operator_reads_the_map_from_a_pass_of_its_own) {
  const std::vector<int> requested{row("laplacian"), row("sphere_volume")};
  const std::vector<Pass> passes = plan_passes(requested, row("sphere_volume"));
  ASSERT_EQ(passes.size(), 3u);
  EXPECT_EQ(passes[0].stage, Stage::surface);
  EXPECT_EQ(passes[1].stage, Stage::source);
  EXPECT_EQ(passes[1].rows, std::vector<int>{row("sphere_volume")});
  EXPECT_EQ(passes[2].rows, std::vector<int>{row("laplacian")});
}

// Two points; a pass gives 100 times its number plus the point, or the map it was given.
TEST(Passes, harris_is_given_the_map_and_its_gradient_and_values_come_back_in_order) {
  const std::vector<int> requested{row("harris"), row("mean_curvature"), row("difference_of_gaussians"),
                                   row("gradient_magnitude")};
  std::vector<Stage> stages;
  const auto run = [&](const Pass &pass, const MapValues *map, int number, int count) {
    EXPECT_EQ(count, 4);
    EXPECT_EQ(static_cast<size_t>(number), stages.size());
    stages.push_back(pass.stage);
    EXPECT_EQ(map != nullptr, number >= 2);
    EXPECT_TRUE(!map || map->at(1) == (number == 2 ? vec4(0, 0, 0, 101) : vec4(201, 202, 203, 101)));
    CenterResults results;
    for (const int one : pass.rows) {
      std::vector<float> &values = results.values.emplace_back();
      for (int point = 0; point < 2; ++point)
        for (int k = 0; k < descriptor_row(one).components; ++k) values.push_back(static_cast<float>(100 * number + point + k));
    }
    return results;
  };
  const CenterResults results = run_passes(requested, row("sphere_volume"), run);
  EXPECT_EQ(stages, (std::vector<Stage>{Stage::surface, Stage::source, Stage::map, Stage::windows}));
  ASSERT_EQ(results.values.size(), 4u);
  const float expected[] = {301, 1, 301, 201};
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(results.values[i][1], expected[i]) << i;
}

} // namespace
} // namespace paradesc::test
