// Squares of a grid → their order along Morton's curve.
#pragma once

#include <cstdint>

namespace paradesc {

// Interleaves the bits of both coordinates, so that consecutive squares lie close together. Coordinates have up to 15 bits.
inline int32_t on_curve(int32_t x, int32_t y) {
  int32_t curve = 0;
  for (int bit = 0; bit < 15; ++bit) curve |= (x >> bit & 1) << 2 * bit | (y >> bit & 1) << (2 * bit + 1);
  return curve;
}

} // namespace paradesc
