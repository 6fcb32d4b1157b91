// Sheets over a square of side 2.
#pragma once

#include <random>

#include "support/triangle_lists.h"

namespace paradesc::test::shapes {

// A sheet over a square of side 2 with steps that are irregular and longer along y.
inline Shape sheet(int side, float stretch, float (*height)(float x, float y), float lift = 0.0f) {
  std::mt19937 random(7);
  const auto jitter = [&] { return 0.3f * (static_cast<float>(random() % 1024) / 512.0f - 1.0f); };
  Shape shape;
  const float step = 2.0f / static_cast<float>(side);
  for (int i = 0; i <= side; ++i)
    for (int k = 0; k <= side; ++k) {
      const bool middle = 2 * i == side && 2 * k == side;
      const float x = (static_cast<float>(i) + (middle ? 0.0f : jitter())) * step - 1.0f;
      const float y = (static_cast<float>(k) + (middle ? 0.0f : jitter())) * step - 1.0f;
      shape.positions.emplace_back(x, stretch * y, lift + height(x, stretch * y));
    }
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const int32_t a = i * (side + 1) + k, b = a + side + 1;
      shape.faces.insert(shape.faces.end(), {a, b, b + 1, a, b + 1, a + 1});
    }
  return shape;
}
inline float bowl(float x, float y) { return 0.2f * (x * x + y * y); }
inline float dome(float x, float y) { return -0.3f * (x * x + y * y); }

} // namespace paradesc::test::shapes
