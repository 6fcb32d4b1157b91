// Up to 24 balls of one radius, looked at side by side: each is a lane, and one bit of what is known of a position.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "support/math.h"

namespace paradesc {

class BallLanes {
public:
  static constexpr size_t max_lanes = 24;
  static constexpr size_t width = 4; // lanes that all processors handle at once
  using Floats [[gnu::vector_size(width * sizeof(float))]] = float;
  using Bits [[gnu::vector_size(width * sizeof(int32_t))]] = int32_t;
  // A value for each lane.
  using FloatOfEach = Floats[max_lanes / width];
  using BitsOfEach = Bits[max_lanes / width];

  explicit BallLanes(double radius) : scale_(static_cast<float>(1.0 / radius)) {}

  // center(lane) of the first `count` lanes; those that fill the last vector are as the last one.
  template <class Center> void set(size_t count, const Center &center) {
    vectors_ = (count + width - 1) / width;
    all_ = (uint32_t{1} << count) - 1;
    for (size_t lane = 0; lane < vectors_ * width; ++lane) {
      const vec3 position = center(std::min(lane, count - 1));
      for (int axis = 0; axis < 3; ++axis) centers_[lane / width][axis][lane % width] = position[axis];
    }
  }

  size_t vectors() const { return vectors_; }
  uint32_t all() const { return all_; }
  float scale() const { return scale_; } // 1 / radius
  // The centers, in the units of the positions.
  const Floats &centers(size_t vector, int axis) const { return centers_[vector][axis]; }

  // The offset from a lane's center, in units of the radius.
  vec3 offset(vec3 position, size_t lane) const {
    const Floats(&center)[3] = centers_[lane / width];
    const size_t k = lane % width;
    return (position - vec3(center[0][k], center[1][k], center[2][k])) * scale_;
  }

  // Squared distances from the centers, in units of the radius.
  Floats squares(vec3 position, size_t vector) const {
    const Floats(&center)[3] = centers_[vector];
    const Floats x = (position.x - center[0]) * scale_, y = (position.y - center[1]) * scale_,
                 z = (position.z - center[2]) * scale_;
    return x * x + y * y + z * z;
  }

  // The lanes for which test(vector) is true, -1.
  template <class Test> uint32_t where(const Test &test) const {
    Bits lanes{};
    for (size_t i = 0; i < vectors_; ++i) lanes |= test(i) & (Bits{1, 2, 4, 8} << static_cast<int32_t>(width * i));
    return static_cast<uint32_t>(lanes[0] | lanes[1] | lanes[2] | lanes[3]);
  }

  // The lanes whose ball holds a position.
  uint32_t holding(vec3 position) const {
    return where([&](size_t i) { return squares(position, i) < 1.0f; });
  }

  // -1 for those of a vector that are among the lanes, else 0.
  static Bits are_in(uint32_t lanes, size_t vector) {
    return ((Bits{} + static_cast<int32_t>(lanes >> width * vector)) & Bits{1, 2, 4, 8}) != 0;
  }

  template <class Visit> static void for_each(uint32_t lanes, const Visit &visit) {
    for (; lanes; lanes &= lanes - 1) visit(static_cast<size_t>(std::countr_zero(lanes)));
  }

private:
  float scale_;
  Floats centers_[max_lanes / width][3]; // by axis
  size_t vectors_ = 0;
  uint32_t all_ = 0;
};

} // namespace paradesc
