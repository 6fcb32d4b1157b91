// Vectors of LANE_WIDTH floats (8 unless it is set), and vectors of as many booleans.
//
// They are compiler vectors, which GCC and Clang support on every processor. Each lane is rounded like a single float, so results
// do not depend on the width. KERNEL_TARGET names the code of one set of instructions: otherwise the linker would merge inline
// functions that are compiled for several sets.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#ifndef LANE_WIDTH
#define LANE_WIDTH 8
#endif
#ifndef KERNEL_TARGET
#define KERNEL_TARGET any
#endif

#pragma GCC diagnostic ignored "-Wpsabi" // vectors that are passed by value stay within one object file

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

inline constexpr int lane_count = LANE_WIDTH;

struct Choices {
  using Bits [[gnu::vector_size(LANE_WIDTH * sizeof(int32_t))]] = int32_t;
  Bits lane; // -1: yes, 0: no
};

struct Lanes {
  using Floats [[gnu::vector_size(LANE_WIDTH * sizeof(float))]] = float;
  Floats lane;
  Lanes() = default;
  Lanes(float all) : lane(Floats{} + all) {} // for literals
  explicit Lanes(double all) : Lanes(static_cast<float>(all)) {}
  explicit Lanes(const Floats &values) : lane(values) {}
};

inline Lanes operator+(const Lanes &a, const Lanes &b) { return Lanes(a.lane + b.lane); }
inline Lanes operator-(const Lanes &a, const Lanes &b) { return Lanes(a.lane - b.lane); }
inline Lanes operator*(const Lanes &a, const Lanes &b) { return Lanes(a.lane * b.lane); }
inline Lanes operator/(const Lanes &a, const Lanes &b) { return Lanes(a.lane / b.lane); }
inline Lanes operator-(const Lanes &a) { return Lanes(-a.lane); }
inline Lanes &operator+=(Lanes &a, const Lanes &b) { return a = a + b; }
inline Choices operator<(const Lanes &a, const Lanes &b) { return {a.lane < b.lane}; }
inline Choices operator>(const Lanes &a, const Lanes &b) { return {a.lane > b.lane}; }
inline Choices operator>=(const Lanes &a, const Lanes &b) { return {a.lane >= b.lane}; }
inline Choices operator==(const Lanes &a, const Lanes &b) { return {a.lane == b.lane}; }
inline Choices operator||(const Choices &a, const Choices &b) { return {a.lane | b.lane}; }
inline Choices operator&&(const Choices &a, const Choices &b) { return {a.lane & b.lane}; }
inline Choices operator!=(const Choices &a, const Choices &b) { return {a.lane ^ b.lane}; }
inline Choices operator!(const Choices &a) { return {~a.lane}; }

// One choice per bit; the lowest bit is the first lane's.
inline Choices choices_of(uint32_t bits) {
  Choices::Bits of_lane;
  for (int i = 0; i < lane_count; ++i) of_lane[i] = 1 << i;
  return {((Choices::Bits{} + static_cast<int32_t>(bits)) & of_lane) != 0};
}

inline Lanes mix(const Lanes &a, const Lanes &b, const Choices &choice) { return Lanes(choice.lane ? b.lane : a.lane); }
// Given NaN and a number, min and max return the first: as the processor's own instructions do, which compilers do not find by
// themselves.
#if defined(__AVX512F__) && LANE_WIDTH == 16
#define PARADESC_LANES_BY(name)                                                                                                  \
  Lanes(std::bit_cast<Lanes::Floats>(                                                                                            \
      _mm512_maskz_##name##_ps(0xffff, std::bit_cast<__m512>(b.lane), std::bit_cast<__m512>(a.lane))))
#elif defined(__AVX2__) && LANE_WIDTH == 8
#define PARADESC_LANES_BY(name)                                                                                                  \
  Lanes(std::bit_cast<Lanes::Floats>(_mm256_##name##_ps(std::bit_cast<__m256>(b.lane), std::bit_cast<__m256>(a.lane))))
#elif defined(__SSE2__) && LANE_WIDTH == 4
#define PARADESC_LANES_BY(name)                                                                                                  \
  Lanes(std::bit_cast<Lanes::Floats>(_mm_##name##_ps(std::bit_cast<__m128>(b.lane), std::bit_cast<__m128>(a.lane))))
#endif
#ifdef PARADESC_LANES_BY
inline Lanes min(const Lanes &a, const Lanes &b) { return PARADESC_LANES_BY(min); }
inline Lanes max(const Lanes &a, const Lanes &b) { return PARADESC_LANES_BY(max); }
#undef PARADESC_LANES_BY
#else
inline Lanes min(const Lanes &a, const Lanes &b) { return mix(a, b, b < a); }
inline Lanes max(const Lanes &a, const Lanes &b) { return mix(a, b, a < b); }
#endif
inline Lanes abs(const Lanes &a) {
  return Lanes(std::bit_cast<Lanes::Floats>(std::bit_cast<Choices::Bits>(a.lane) & 0x7fffffff));
}
inline Choices isnan(const Lanes &a) { return {a.lane != a.lane}; }
inline Lanes sqrt(const Lanes &a) {
  Lanes result;
  for (int i = 0; i < lane_count; ++i) result.lane[i] = std::sqrt(a.lane[i]);
  return result;
}

// 1/sqrt(a) with a relative error of 7e-7, for normal numbers above 0; several times as fast as a root and a division. A first
// guess from the exponent is refined by two steps of Newton's method, the first with constants that minimize the error.
inline Lanes fast_inversesqrt(const Lanes &a) {
  Lanes root(std::bit_cast<Lanes::Floats>(0x5f200000 - (std::bit_cast<Choices::Bits>(a.lane) >> 1)));
  root = root * (1.681912f - 0.7039497f * a * root * root);
  return root * (1.5f - 0.5f * a * root * root);
}

// exp(a) with a relative error of 2e-7, unless a is NaN or far above 0: 2^n e^f by a polynomial, n an integer, |f| <= ln(2)/2.
inline Lanes exp(const Lanes &a) {
  const Lanes x = max(a, -87.0f), whole_maker = 12582912.0f; // 1.5 * 2^23: floats near it are integers
  const Lanes shifted = x * 1.44269504f + whole_maker, n = shifted - whole_maker;
  const Lanes f = (x - n * 0.693359375f) - n * -2.12194440e-4f; // ln(2) in two parts: n times the first is exact
  Lanes sum = 1.98756915e-4f;
  for (const float term : {1.39819995e-3f, 8.33345191e-3f, 4.16657968e-2f, 0.166666657f, 0.5f}) sum = sum * f + term;
  sum = sum * f * f + f + 1.0f;
  const auto bits = std::bit_cast<Choices::Bits>(shifted.lane) - std::bit_cast<int32_t>(12582912.0f) + 127;
  return sum * Lanes(std::bit_cast<Lanes::Floats>(bits << 23));
}

// The sum of all lanes. Halves are added first, so that the order of sums does not depend on the width: lanes of a wider vector
// are added in pairs to give those of a vector half as wide.
template <size_t width> float sum_of(const std::array<float, width> &lanes) {
  if constexpr (width == 1) {
    return lanes[0];
  } else {
    std::array<float, width / 2> half;
    for (size_t i = 0; i < width / 2; ++i) half[i] = lanes[i] + lanes[i + width / 2];
    return sum_of(half);
  }
}

// Adds up the sums of all lanes: a struct of lanes becomes the same struct of floats.
template <class Narrow, class Wide> Narrow add_lanes(const Wide &wide) {
  constexpr size_t count = sizeof(Narrow) / sizeof(float);
  static_assert(sizeof(Wide) == lane_count * sizeof(Narrow));
  const auto lanes = std::bit_cast<std::array<std::array<float, lane_count>, count>>(wide);
  std::array<float, count> sums;
  for (size_t i = 0; i < count; ++i) sums[i] = sum_of(lanes[i]);
  return std::bit_cast<Narrow>(sums);
}

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
