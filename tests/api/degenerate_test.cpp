// Meshes with nothing to measure, or too much for a float: every value is written, as a number or as NaN.
#include <cmath>
#include <string>
#include <vector>

#include "support/api_fixture.h"

namespace paradesc::test {
namespace {

const std::string direction = "principal_direction_max", volume = "sphere_volume", area = "euclidean_area";

// Found by fuzzing: two thirds of the values were left as they were.
TEST_F(Api, a_mesh_without_area_has_undefined_directions_in_all_components) {
  for (float &x : ball.positions) x = 1.0f;
  const std::string names[] = {direction, "mean_curvature"};
  const Results results = compute(context.get(), ball, {.radius = 0.5}, names);
  ASSERT_EQ(results[direction].size(), 3 * static_cast<size_t>(ball.vertex_count));
  for (const float x : results[direction]) EXPECT_TRUE(std::isnan(x)) << x;
  EXPECT_EQ(results.report.undefined_vertices, ball.vertex_count);
}

// Found by fuzzing: they were infinite.
TEST_F(Api, a_value_that_no_float_holds_is_undefined) {
  for (float &x : ball.positions) x *= 5e17f;
  const std::string names[] = {volume, area};
  const Results results = compute(context.get(), ball, {.radius = 0.2}, names);
  for (const float x : results[volume]) EXPECT_TRUE(std::isnan(x)) << x;
  for (const float x : results[area]) EXPECT_TRUE(std::isfinite(x)) << x;
  EXPECT_EQ(results.report.undefined_vertices, ball.vertex_count);
}

} // namespace
} // namespace paradesc::test
