// Results against a reference → the percentage of absolute error, by the one definition of this project:
//   %AE = 100 mean |x - ref| / (P97.5(ref) - P2.5(ref)), percentiles over all of the reference's values.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace paradesc::test {

struct PercentAe {
  double mean = 0, median = 0, p99 = 0, max = 0;
  double range = 0; // the denominator
  int count = 0;    // of vertices compared
};

// Undefined (NaN) on both sides: left out; on one side only: 100 %. subset: empty, or 1 for each vertex to compare.
// If the reference is constant, its magnitude is the denominator; if it is zero, flat_scale is the denominator (1/r for H and k
// on a plane, 1/r² for K and bending energy).
PercentAe percent_ae(std::span<const float> values, std::span<const double> reference, std::span<const uint8_t> subset = {},
                     double flat_scale = 0);

std::vector<double> as_double(std::span<const float> values);

// 1 where a is and b is not.
std::vector<uint8_t> without(std::span<const uint8_t> a, std::span<const uint8_t> b);

} // namespace paradesc::test
