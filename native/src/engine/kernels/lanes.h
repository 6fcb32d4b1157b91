// Eight floats that are computed with together, on every instruction set in the same order; and eight choices between them.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace paradesc::kernels {

inline constexpr int lane_count = 8;

struct Choices {
  std::array<bool, lane_count> lane;
};

struct Lanes {
  std::array<float, lane_count> lane;
  Lanes() = default;
  Lanes(float all) { lane.fill(all); } // of literals
  explicit Lanes(double all) : Lanes(static_cast<float>(all)) {}
  explicit Lanes(const std::array<float, lane_count> &values) : lane(values) {}

  float sum() const {
    const auto &v = lane;
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
  }
};

template <class Of> Lanes each_lane(const Lanes &a, const Lanes &b, const Of &of) {
  Lanes result;
  for (size_t i = 0; i < lane_count; ++i) result.lane[i] = of(a.lane[i], b.lane[i]);
  return result;
}
template <class Of> Choices choose_lanes(const Lanes &a, const Lanes &b, const Of &of) {
  Choices result;
  for (size_t i = 0; i < lane_count; ++i) result.lane[i] = of(a.lane[i], b.lane[i]);
  return result;
}

inline Lanes operator+(const Lanes &a, const Lanes &b) { return each_lane(a, b, [](float x, float y) { return x + y; }); }
inline Lanes operator-(const Lanes &a, const Lanes &b) { return each_lane(a, b, [](float x, float y) { return x - y; }); }
inline Lanes operator*(const Lanes &a, const Lanes &b) { return each_lane(a, b, [](float x, float y) { return x * y; }); }
inline Lanes operator/(const Lanes &a, const Lanes &b) { return each_lane(a, b, [](float x, float y) { return x / y; }); }
inline Lanes operator-(const Lanes &a) { return Lanes(0.0f) - a; }
inline Lanes &operator+=(Lanes &a, const Lanes &b) { return a = a + b; }
inline Choices operator<(const Lanes &a, const Lanes &b) { return choose_lanes(a, b, [](float x, float y) { return x < y; }); }
inline Choices operator>=(const Lanes &a, const Lanes &b) { return choose_lanes(a, b, [](float x, float y) { return x >= y; }); }
inline Choices operator==(const Lanes &a, const Lanes &b) { return choose_lanes(a, b, [](float x, float y) { return x == y; }); }
inline Choices operator||(const Choices &a, const Choices &b) {
  Choices result;
  for (size_t i = 0; i < lane_count; ++i) result.lane[i] = a.lane[i] || b.lane[i];
  return result;
}

inline Lanes min(const Lanes &a, const Lanes &b) { return each_lane(a, b, [](float x, float y) { return y < x ? y : x; }); }
inline Lanes max(const Lanes &a, const Lanes &b) { return each_lane(a, b, [](float x, float y) { return x < y ? y : x; }); }
inline Lanes sqrt(const Lanes &a) { return each_lane(a, a, [](float x, float) { return std::sqrt(x); }); }
inline Lanes exp(const Lanes &a) { return each_lane(a, a, [](float x, float) { return std::exp(x); }); }
inline Choices isnan(const Lanes &a) { return choose_lanes(a, a, [](float x, float) { return std::isnan(x); }); }
inline Lanes mix(const Lanes &a, const Lanes &b, const Choices &choice) {
  Lanes result;
  for (size_t i = 0; i < lane_count; ++i) result.lane[i] = choice.lane[i] ? b.lane[i] : a.lane[i];
  return result;
}

// Adds up the sums of all lanes: a struct of lanes becomes the same struct of floats.
template <class Narrow, class Wide> Narrow add_lanes(const Wide &wide) {
  constexpr size_t count = sizeof(Narrow) / sizeof(float);
  static_assert(sizeof(Wide) == lane_count * sizeof(Narrow));
  const auto lanes = std::bit_cast<std::array<Lanes, count>>(wide);
  std::array<float, count> sums;
  for (size_t i = 0; i < count; ++i) sums[i] = lanes[i].sum();
  return std::bit_cast<Narrow>(sums);
}

} // namespace paradesc::kernels
