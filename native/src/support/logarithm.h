// The natural logarithm, with the same bits on every system: the last bits depend on the C library otherwise.
#pragma once

#include <bit>
#include <cstdint>

namespace paradesc {

// The logarithm of a normal number above 0, to some 1e-16: divides by a power of two, and sums the series of atanh for the rest.
inline double logarithm_of(double x) {
  constexpr double log_of_2 = 0.69314718055994531, root_of_half = 0.70710678118654752;
  constexpr double odd[] = {1.0, 1.0 / 3, 1.0 / 5, 1.0 / 7, 1.0 / 9, 1.0 / 11, 1.0 / 13, 1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21};
  constexpr int last = 10; // (3 - 2 sqrt(2))^(2 * 10 + 3) / 23 is below 1e-18
  constexpr int fraction_bits = 52, bias = 1022;
  constexpr uint64_t fraction = (uint64_t{1} << fraction_bits) - 1;
  const auto bits = std::bit_cast<uint64_t>(x);
  int exponent = static_cast<int>(bits >> fraction_bits) - bias;
  double rest = std::bit_cast<double>((bits & fraction) | (uint64_t{bias} << fraction_bits)); // in [1/2, 1)
  if (rest < root_of_half) {
    rest *= 2.0;
    --exponent;
  }
  const double t = (rest - 1.0) / (rest + 1.0), square = t * t;
  double even_terms = 0.0, odd_terms = 0.0; // two independent chains, which processors compute in parallel
  for (int k = last; k > 0; k -= 2) {
    even_terms = odd[k] + square * square * even_terms;
    odd_terms = odd[k - 1] + square * square * odd_terms;
  }
  return exponent * log_of_2 + 2.0 * t * (odd[0] + square * (odd_terms + square * even_terms));
}

} // namespace paradesc
