// Values at some places → the value between them. Non-finite values are skipped, and the remaining weights are renormalized.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace paradesc {

// A value with room for Width components.
template <size_t Width> using Value = std::array<double, Width>;

// The weighted mean of those values that are defined, each of up to Width consecutive floats; NaN if none is defined. Directions
// have no sign, and their mean is a unit vector.
template <size_t Width, size_t Count>
Value<Width> blended(const std::array<const float *, Count> &values, std::array<double, Count> weights, int components,
                     bool directions) {
  for (size_t i = 0; i < Count; ++i)
    if (!std::all_of(values[i], values[i] + components, [](float x) { return std::isfinite(x); })) weights[i] = 0.0;
  const float *leader = values[std::max_element(weights.begin(), weights.end()) - weights.begin()];
  Value<Width> total{};
  double size = 0.0;
  for (size_t i = 0; i < Count; ++i) {
    if (!(weights[i] > 0.0)) continue;
    const auto component = [&](int c) { return static_cast<double>(values[i][c]); };
    double weight = weights[i];
    size += weight;
    if (directions && component(0) * leader[0] + component(1) * leader[1] + component(2) * leader[2] < 0.0) weight = -weight;
    for (int c = 0; c < components; ++c) total[c] += component(c) * weight;
  }
  if (directions) size = std::sqrt(total[0] * total[0] + total[1] * total[1] + total[2] * total[2]);
  for (int c = 0; c < components; ++c) total[c] = size > 1e-9 ? total[c] / size : std::numeric_limits<double>::quiet_NaN();
  return total;
}

} // namespace paradesc
