#include "support/angle.h"

#include <cmath>

#include <gtest/gtest.h>

#include "support/math.h"

namespace paradesc {
namespace {

// A last bit of pi is 4e-16, and the parts of the sum round, too.
constexpr double rounding = 2e-15;

TEST(Angle, of_any_direction_is_the_c_librarys_but_for_rounding) {
  for (int i = -1000; i <= 1000; ++i) {
    const double turn = i * pi / 1000.0, length = std::exp(0.1 * (i % 50));
    const double x = length * std::cos(turn), y = length * std::sin(turn);
    EXPECT_NEAR(angle_of(y, x), std::atan2(y, x), rounding) << i;
  }
}

TEST(Angle, along_an_axis_is_exact) {
  EXPECT_EQ(angle_of(0.0, 2.0), 0.0);
  EXPECT_EQ(angle_of(2.0, 0.0), pi / 2.0);
  EXPECT_EQ(angle_of(-2.0, 0.0), -pi / 2.0);
  EXPECT_EQ(angle_of(0.0, -2.0), pi);
  EXPECT_EQ(angle_of(0.0, 0.0), 0.0);
}

TEST(Angle, of_what_is_not_a_number_is_none) {
  EXPECT_TRUE(std::isnan(angle_of(NAN, 1.0)));
  EXPECT_TRUE(std::isnan(angle_of(1.0, NAN)));
  EXPECT_TRUE(std::isnan(angle_of(-INFINITY, INFINITY)));
}

} // namespace
} // namespace paradesc
