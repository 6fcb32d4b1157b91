// Vogel's spiral and hashed rotations.
#include "sample/pattern.h"

#include <cmath>

namespace paradesc {

std::vector<vec2> golden_angle_pattern(int count) {
  const double golden_angle = pi * (3.0 - std::sqrt(5.0));
  std::vector<vec2> pattern;
  pattern.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double distance = std::sqrt((i + 0.5) / count);
    pattern.emplace_back(distance * std::cos(i * golden_angle), distance * std::sin(i * golden_angle));
  }
  return pattern;
}

float pattern_rotation(uint32_t point, uint32_t seed) {
  // The finalizer of MurmurHash3 over both numbers.
  uint32_t h = point * 0x9e3779b9u ^ (seed + 0x7f4a7c15u);
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  h ^= h >> 16;
  return static_cast<float>(2.0 * pi * h / 4294967296.0);
}

} // namespace paradesc
