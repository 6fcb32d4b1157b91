// Rounding to 16-bit floats, by the text that shaders are compiled from: no driver has a say in it. Every half is written out
// from its bits here, so that nothing is asked that rounds itself.
#include "engine/paper/half.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace paradesc::test {
namespace {

// The value of a finite half, positive: five bits of exponent, ten of digits. 0x7c00 stands for 2^16 here, where rounding goes to
// infinity.
float half_of(uint32_t bits) {
  const int exponent = static_cast<int>(bits >> 10);
  const auto digits = static_cast<float>(bits & 0x3ffu);
  return exponent == 0 ? std::ldexp(digits, -24) : std::ldexp(1024.0f + digits, exponent - 25);
}

float nearest(float value) { return half_floats::Text().nearest_half(value); }

// The same bits, with either sign.
void expect_rounded(float value, float expected) {
  ASSERT_EQ(std::bit_cast<uint32_t>(nearest(value)), std::bit_cast<uint32_t>(expected)) << value << " becomes " << nearest(value);
  ASSERT_EQ(std::bit_cast<uint32_t>(nearest(-value)), std::bit_cast<uint32_t>(-expected)) << -value;
}

constexpr uint32_t infinite = 0x7c00;
constexpr float infinity = std::numeric_limits<float>::infinity();
float rounded_to(uint32_t bits) { return bits == infinite ? infinity : half_of(bits); }

TEST(HalfRounding, leaves_every_half_as_it_is) {
  for (uint32_t bits = 0; bits < infinite; ++bits) expect_rounded(half_of(bits), half_of(bits));
}

TEST(HalfRounding, takes_the_even_one_in_the_middle_of_two_and_the_nearer_one_beside_it) {
  for (uint32_t bits = 0; bits < infinite; ++bits) {
    const float low = half_of(bits), middle = 0.5f * (low + half_of(bits + 1)); // both exact in 24 digits
    const uint32_t even = bits % 2 == 0 ? bits : bits + 1;
    expect_rounded(middle, rounded_to(even));
    expect_rounded(std::nextafter(middle, 0.0f), rounded_to(bits));
    expect_rounded(std::nextafter(middle, infinity), rounded_to(bits + 1));
    expect_rounded(std::nextafter(low, infinity), rounded_to(bits));
    if (bits > 0) expect_rounded(std::nextafter(low, 0.0f), rounded_to(bits));
  }
}

TEST(HalfRounding, knows_what_is_too_large_and_too_small_for_a_half) {
  expect_rounded(65504.0f, 65504.0f);
  for (const float large : {65536.0f, 1e6f, std::numeric_limits<float>::max(), infinity}) expect_rounded(large, infinity);
  for (const float small : {0.0f, std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::min(), 1e-20f, 2.9e-8f})
    expect_rounded(small, 0.0f);
  EXPECT_TRUE(std::isnan(nearest(std::numeric_limits<float>::quiet_NaN())));
}

// The code of the rest restores a rounded position to a part of 2^-16 and a rounded normal to a part of 2^-18.
TEST(HalfRounding, leaves_a_rest_that_codes_hold) {
  half_floats::Text text;
  for (int i = -1000; i <= 1000; ++i) {
    const vec3 position(static_cast<float>(i) / 1000.0f, std::sin(static_cast<float>(i)), std::cos(static_cast<float>(3 * i)));
    const vec3 rounded = text.nearest_half(position);
    const float three = text.code_of_three(position - rounded), two = text.code_of_two(vec2(position) - vec2(rounded));
    EXPECT_EQ(nearest(three), three) << "a code is a half itself";
    EXPECT_EQ(nearest(two), two);
    const vec3 back = rounded + text.three_of_code(three);
    const vec2 finer = vec2(rounded) + text.two_of_code(two);
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(back[k] - position[k]), std::ldexp(1.001f, -16));
    for (int k = 0; k < 2; ++k) EXPECT_LE(std::abs(finer[k] - position[k]), std::ldexp(1.01f, -18));
  }
}

} // namespace
} // namespace paradesc::test
