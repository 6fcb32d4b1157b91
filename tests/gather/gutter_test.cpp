// The gutter of images through the C interface: which texels are filled, with what, and what is left alone.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "support/api_fixture.h"

namespace paradesc::test {
namespace {

constexpr float none = std::numeric_limits<float>::quiet_NaN();
constexpr float infinite = std::numeric_limits<float>::infinity();

std::vector<float> filled(std::vector<float> image, int32_t width, int32_t height, int32_t steps, int32_t components = 1,
                          int32_t threads = 1) {
  const auto count = static_cast<int64_t>(image.size());
  EXPECT_EQ(pdesc_uv_image_fill_gutter(image.data(), count, width, height, components, steps, threads), PDESC_OK)
      << pdesc_last_error();
  return image;
}

TEST(Gutter, of_one_texel_grows_by_a_ring_a_step_and_ends) {
  constexpr int side = 15;
  std::vector<float> image(side * side, none);
  image[7 * side + 7] = 2.5f;
  for (const int steps : {0, 1, 4, 7}) {
    const auto found = filled(image, side, side, steps);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const int ring = std::max(std::abs(x - 7), std::abs(y - 7));
        EXPECT_EQ(found[static_cast<size_t>(y * side + x)], ring <= steps ? 2.5f : 0.0f) << steps << ": " << x << ", " << y;
      }
  }
}

TEST(Gutter, takes_the_mean_of_what_was_defined_before_the_step) {
  const std::vector<float> image = {1, none, 4, none, none, none, none, none, 8, none, none, none};
  //  1   .   4   .        1    2.5   4   4
  //  .   .   .   .   →   4.5  13/3   4   4
  //  8   .   .   .        8    8     .   .
  const std::vector<float> expected = {1, 2.5f, 4, 4, 4.5f, 13.0f / 3.0f, 4, 4, 8, 8, 0, 0};
  const auto found = filled(image, 4, 3, 1);
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(found[i], expected[i]) << i;
}

TEST(Gutter, of_several_components_takes_a_texel_for_undefined_where_one_of_them_is) {
  const std::vector<float> image = {1, 10, none, 20, 3, 30, none, infinite, none, 5};
  const auto found = filled(image, 5, 1, 1, 2);
  const std::vector<float> expected = {1, 10, 2, 20, 3, 30, 3, 30, 0, 5}; // the last is beyond the ring: what it has stays
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(found[i], expected[i]) << i;
}

TEST(Gutter, takes_a_sum_that_overflows_for_undefined) {
  const float large = 3e38f;
  const auto once = filled({large, none, large}, 3, 1, 1), often = filled({large, none, large, none}, 4, 1, 3);
  EXPECT_EQ(once[1], 0.0f);
  EXPECT_EQ(often[1], 0.0f);
  EXPECT_EQ(often[3], large);
}

TEST(Gutter, leaves_defined_texels_alone_and_needs_none) {
  const std::vector<float> whole = {1, -2, 3, -4, 0.5f, 1e30f};
  EXPECT_EQ(filled(whole, 3, 2, 8), whole);
  EXPECT_EQ(filled(std::vector<float>(6, none), 2, 3, 8), std::vector<float>(6, 0.0f));
  EXPECT_EQ(filled({-infinite}, 1, 1, 64), std::vector<float>(1, 0.0f));
}

TEST(Gutter, does_not_depend_on_the_number_of_threads) {
  constexpr int width = 200, height = 333;
  std::vector<float> image(width * height, none);
  for (size_t i = 0; i < image.size(); i += 1 + i % 97) image[i] = std::sin(static_cast<float>(i));
  const auto expected = filled(image, width, height, 8);
  for (const int32_t threads : {2, 7, 0}) EXPECT_EQ(filled(image, width, height, 8, 1, threads), expected);
}

TEST(Gutter, refuses_sizes_that_do_not_fit_in_a_sentence_that_names_them) {
  std::vector<float> image(12, none);
  const auto refused = [&](std::initializer_list<const char *> offenders, int64_t count, int32_t width, int32_t height,
                           int32_t components, int32_t steps, int32_t threads) {
    expect_refused(pdesc_uv_image_fill_gutter(image.data(), count, width, height, components, steps, threads),
                   PDESC_ERROR_INVALID_ARGUMENT, offenders);
    for (const float x : image) EXPECT_TRUE(std::isnan(x));
  };
  refused({"room for 12", "24 are needed"}, 12, 4, 3, 2, 8, 1);
  refused({"width", "0"}, 12, 0, 3, 1, 8, 1);
  refused({"height", "16385"}, 12, 1, 16385, 1, 8, 1);
  refused({"components", "5"}, 12, 1, 1, 5, 8, 1);
  refused({"steps", "65"}, 12, 4, 3, 1, 65, 1);
  refused({"steps", "-1"}, 12, 4, 3, 1, -1, 1);
  refused({"threads", "-1"}, 12, 4, 3, 1, 8, -1);
  expect_refused(pdesc_uv_image_fill_gutter(nullptr, 12, 4, 3, 1, 8, 1), PDESC_ERROR_INVALID_ARGUMENT, {"image"});
}

} // namespace
} // namespace paradesc::test
