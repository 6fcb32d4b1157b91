// Vogel's spiral, jittered strata and hashed rotations.
#include "engine/paper/pattern.h"

#include <algorithm>
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

// The finalizer of MurmurHash3.
static uint32_t hash(uint32_t h) {
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  return h ^ (h >> 16);
}

dvec2 concentric_disk(dvec2 square) {
  if (square.x == 0.0 && square.y == 0.0) return dvec2(0.0);
  const bool wide = std::abs(square.x) > std::abs(square.y);
  const double distance = wide ? square.x : square.y;
  const double angle = wide ? pi / 4.0 * square.y / square.x : pi / 2.0 - pi / 4.0 * square.x / square.y;
  return distance * dvec2(std::cos(angle), std::sin(angle));
}

std::vector<vec2> stratified_pattern(int count, uint32_t seed) {
  const int rows = std::max(1, static_cast<int>(std::lround(std::sqrt(count))));
  std::vector<vec2> pattern;
  pattern.reserve(static_cast<size_t>(count));
  uint32_t state = hash(seed ^ 0x51ed270bu);
  auto random = [&] { return (state = hash(state + 0x9e3779b9u)) / 4294967296.0; };
  for (int row = 0; row < rows; ++row) {
    const auto begin = static_cast<int>(static_cast<int64_t>(count) * row / rows);
    const auto end = static_cast<int>(static_cast<int64_t>(count) * (row + 1) / rows);
    for (int i = begin; i < end; ++i) {
      const int column = row % 2 == 0 ? i - begin : end - 1 - i;
      const double x = (column + random()) / (end - begin), y = (begin + (end - begin) * random()) / count;
      pattern.emplace_back(concentric_disk(2.0 * dvec2(x, y) - 1.0));
    }
  }
  return pattern;
}

float pattern_rotation(uint32_t point, uint32_t seed) {
  return static_cast<float>(2.0 * pi * hash(point * 0x9e3779b9u ^ (seed + 0x7f4a7c15u)) / 4294967296.0);
}

} // namespace paradesc
