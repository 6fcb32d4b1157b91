// Values that two ways of computing give: alike but for rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include <gtest/gtest.h>

namespace paradesc::test {

// Expects NaN on both sides or on none. Values that exist may differ by this part of the value, or of its usual size if that is
// larger. Returns how many values exist.
inline int expect_like(std::span<const float> values, std::span<const float> expected, std::span<const double> usual,
                       double part) {
  EXPECT_EQ(values.size(), expected.size());
  int existing = 0;
  for (size_t i = 0; i < std::min(values.size(), expected.size()); ++i) {
    EXPECT_EQ(std::isnan(values[i]), std::isnan(expected[i])) << "value " << i << ": " << values[i] << ", not " << expected[i];
    if (std::isnan(expected[i])) continue;
    EXPECT_NEAR(values[i], expected[i], part * std::max<double>(std::abs(expected[i]), usual[i])) << "value " << i;
    ++existing;
  }
  return existing;
}

} // namespace paradesc::test
