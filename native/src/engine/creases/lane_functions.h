// Functions of lanes that curvature's kernels need. It is compiled for each instruction set, as KERNEL_TARGET.
#pragma once

#include <bit>

#include "engine/kernels/vectors.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

// The natural logarithm of normal numbers above 0, to 1e-7 of the larger of itself and 1: a power of two, and a polynomial for
// the rest, which lies between the roots of 1/2 and 2.
inline Lanes logarithm(const Lanes &a) {
  constexpr int root_of_half = 0x3f3504f3, fraction_bits = 23;
  const auto bits = std::bit_cast<Choices::Bits>(a.lane);
  const Choices::Bits exponent = (bits - root_of_half) >> fraction_bits;
  const Lanes n(__builtin_convertvector(exponent, Lanes::Floats));
  const Lanes x = Lanes(std::bit_cast<Lanes::Floats>(bits - (exponent << fraction_bits))) - 1.0f, square = x * x;
  Lanes sum = 7.0376836292e-2f;
  for (const float term : {-1.1514610310e-1f, 1.1676998740e-1f, -1.2420140846e-1f, 1.4249322787e-1f, -1.6668057665e-1f,
                           2.0000714765e-1f, -2.4999993993e-1f, 3.3333331174e-1f})
    sum = sum * x + term;
  // ln(2) in two parts: n times the first is exact.
  return n * 0.693359375f + (x + (x * square * sum - n * 2.12194440e-4f - 0.5f * square));
}

// The angle in [-pi, pi] from the x axis towards the y axis, to some 2e-7; 0 for the zero vector. Slopes above tan(pi/8) are
// turned back by pi/4.
inline Lanes angle(const Lanes &y, const Lanes &x) {
  constexpr float tangent = 0.41421356f, quarter = 0.78539816f, half = 1.57079633f, whole = 3.14159265f;
  const Lanes up = abs(y), across = abs(x), low = min(up, across), high = max(up, across);
  const Choices is_steep = low > high * tangent;
  const Lanes t = mix(low, low - high, is_steep) / max(mix(high, low + high, is_steep), 1e-37f), square = t * t;
  Lanes sum = 8.05374449538e-2f;
  for (const float term : {-1.38776856032e-1f, 1.99777106478e-1f, -3.33329491539e-1f}) sum = sum * square + term;
  Lanes result = mix(0.0f, quarter, is_steep) + (sum * square * t + t);
  result = mix(result, half - result, up > across);
  result = mix(result, whole - result, x < 0.0f);
  return mix(result, -result, y < 0.0f);
}

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
