// Loads lanes from memory, stores them, and turns masks of lanes into bits. It is compiled for each instruction set, as
// KERNEL_TARGET.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "engine/kernels/vectors.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

using FourFloats [[gnu::vector_size(16)]] = float;
using EightFloats [[gnu::vector_size(32)]] = float;
using SixteenFloats [[gnu::vector_size(64)]] = float;

inline Lanes load(const float *from) {
  Lanes lanes;
  __builtin_memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
inline void store(float *to, const Lanes &lanes) { __builtin_memcpy(to, &lanes, sizeof lanes); }
template <int count> Vector<3, Lanes> load3(const float (*v)[count], int first) {
  return {load(v[0] + first), load(v[1] + first), load(v[2] + first)};
}
inline Vector<3, Lanes> all(const float *v) { return {v[0], v[1], v[2]}; }

inline Lanes square_of(const Vector<3, Lanes> &v) { return dot(v, v); }
inline Lanes fast_sqrt(const Lanes &square) { return square * fast_inversesqrt(max(square, 1e-30f)); }

inline bool any(const Choices &choices) {
  using Words = std::array<uint64_t, lane_count / 2>;
  uint64_t all = 0;
  for (const uint64_t word : std::bit_cast<Words>(choices)) all |= word;
  return all != 0;
}

// Selects floats of a and b by constants within each group of four: 0 to 3 select from a, 4 to 7 from b.
template <int i0, int i1, int i2, int i3, size_t... k>
Lanes::Floats shuffle(const Lanes::Floats &a, const Lanes::Floats &b, std::index_sequence<k...>) {
  constexpr int from[4] = {i0, i1, i2, i3};
  return __builtin_shufflevector(a, b, (from[k % 4] % 4 + static_cast<int>(k / 4) * 4 + from[k % 4] / 4 * lane_count)...);
}
template <int i0, int i1, int i2, int i3> Lanes::Floats shuffle(const Lanes::Floats &a, const Lanes::Floats &b) {
  return shuffle<i0, i1, i2, i3>(a, b, std::make_index_sequence<lane_count>());
}

// Loads four floats of every fourth item into consecutive groups of four lanes.
template <size_t offset, class Item> Lanes::Floats every_fourth(const Item *const *items) {
  const auto part = [&](int i) {
    FourFloats four;
    __builtin_memcpy(&four, reinterpret_cast<const char *>(items[i]) + offset, sizeof four);
    return four;
  };
  if constexpr (lane_count == 4) {
    return part(0);
  } else {
    const auto two = [&](int i) { return __builtin_shufflevector(part(i), part(i + 4), 0, 1, 2, 3, 4, 5, 6, 7); };
    if constexpr (lane_count == 8)
      return two(0);
    else
      return __builtin_shufflevector(two(0), two(8), 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  }
}

// Loads four consecutive floats of each item, and transposes them.
template <size_t offset, class Item> [[gnu::always_inline]] inline Vector<4, Lanes> gather(const Item *const *items) {
  const Lanes::Floats a = every_fourth<offset>(items), b = every_fourth<offset>(items + 1), c = every_fourth<offset>(items + 2),
                      d = every_fourth<offset>(items + 3);
  const Lanes::Floats ab = shuffle<0, 4, 1, 5>(a, b), cd = shuffle<0, 4, 1, 5>(c, d);
  const Lanes::Floats ab2 = shuffle<2, 6, 3, 7>(a, b), cd2 = shuffle<2, 6, 3, 7>(c, d);
  return {Lanes(shuffle<0, 1, 4, 5>(ab, cd)), Lanes(shuffle<2, 3, 6, 7>(ab, cd)), Lanes(shuffle<0, 1, 4, 5>(ab2, cd2)),
          Lanes(shuffle<2, 3, 6, 7>(ab2, cd2))};
}
inline Vector<3, Lanes> first3(const Vector<4, Lanes> &v) { return {v.x, v.y, v.z}; }

// Returns the mask of lanes as bits.
inline uint32_t bits_of(const Choices &choices) {
#if defined(__AVX512DQ__) && LANE_WIDTH == 16
  return _mm512_movepi32_mask(std::bit_cast<__m512i>(choices.lane));
#elif defined(__AVX2__) && LANE_WIDTH == 8
  return static_cast<uint32_t>(_mm256_movemask_ps(std::bit_cast<__m256>(choices.lane)));
#elif defined(__SSE2__) && LANE_WIDTH == 4
  return static_cast<uint32_t>(_mm_movemask_ps(std::bit_cast<__m128>(choices.lane)));
#else
  uint32_t bits = 0;
  for (int i = 0; i < lane_count; ++i) bits |= (choices.lane[i] & 1u) << i;
  return bits;
#endif
}

// Returns the sum of a vector's floats. Halves are added first, in the order of sum_of().
inline float fold(const FourFloats &v) { return (v[0] + v[2]) + (v[1] + v[3]); }
inline float fold(const EightFloats &v) {
  const auto halves = std::bit_cast<std::array<FourFloats, 2>>(v);
  return fold(halves[0] + halves[1]);
}
inline float fold(const SixteenFloats &v) {
  const auto halves = std::bit_cast<std::array<EightFloats, 2>>(v);
  return fold(halves[0] + halves[1]);
}
// The same for lanes that are stored in several parts.
template <size_t parts> inline float fold_lanes(const Lanes (&lanes)[parts]) {
  if constexpr (parts == 1) {
    return fold(lanes[0].lane);
  } else {
    Lanes half[parts / 2];
    for (size_t i = 0; i < parts / 2; ++i) half[i] = lanes[i] + lanes[i + parts / 2];
    return fold_lanes(half);
  }
}

// For each set of eight, the indices of its elements in order.
constexpr auto places_of_eight = [] {
  std::array<std::array<uint8_t, 8>, 256> table{};
  for (size_t bits = 0; bits < table.size(); ++bits)
    for (size_t i = 0, count = 0; i < 8; ++i)
      if ((bits >> i & 1) != 0) table[bits][count++] = static_cast<uint8_t>(i);
  return table;
}();

// Appends the values of the lanes whose bits are set, and returns the new length. It may overwrite as many items behind the end
// as there are lanes.
inline int32_t append(uint32_t bits, const Choices::Bits &values, int32_t *list, int32_t count) {
#if defined(__AVX512F__) && LANE_WIDTH == 16
  const __m512i packed = _mm512_maskz_compress_epi32(static_cast<__mmask16>(bits), std::bit_cast<__m512i>(values));
  _mm512_storeu_si512(list + count, packed);
  return count + __builtin_popcount(bits);
#elif defined(__AVX2__) && LANE_WIDTH == 8
  const __m128i places = _mm_loadl_epi64(reinterpret_cast<const __m128i *>(places_of_eight[bits].data()));
  const __m256i packed = _mm256_permutevar8x32_epi32(std::bit_cast<__m256i>(values), _mm256_cvtepu8_epi32(places));
  _mm256_storeu_si256(reinterpret_cast<__m256i *>(list + count), packed);
  return count + __builtin_popcount(bits);
#else
  for (int i = 0; i < lane_count; ++i) {
    list[count] = values[i];
    count += static_cast<int32_t>(bits >> i & 1);
  }
  return count;
#endif
}

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
