// Squares of a grid → their order along Morton's curve.
#pragma once

#include <cstdint>

namespace paradesc {

// The bits of both numbers by turns: squares that follow each other lie close together. Numbers of up to 15 bits.
inline int32_t on_curve(int32_t x, int32_t y) {
  int32_t curve = 0;
  for (int bit = 0; bit < 15; ++bit) curve |= (x >> bit & 1) << 2 * bit | (y >> bit & 1) << (2 * bit + 1);
  return curve;
}

} // namespace paradesc
