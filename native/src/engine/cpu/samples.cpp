// Blocks are written once and read by lanes.
#include "engine/cpu/samples.h"

#include <algorithm>
#include <bit>
#include <cmath>

#define LANE_WIDTH 16
#define KERNEL_TARGET blocks
#include "engine/kernels/lanes.h"

namespace paradesc {

void Samples::clear(bool with_map) {
  rows_ = with_map ? ALL_ROWS : SURFACE_ROWS;
  count_ = 0;
}

void Samples::reserve(int32_t count) {
  const size_t needed = static_cast<size_t>((count + block_lanes - 1) / block_lanes) * static_cast<size_t>(rows_);
  if (blocks_.size() < needed) blocks_.resize(needed + needed / 2);
}

void Samples::add(const Sample &sample) {
  const auto &[position, normal, face, area, map] = sample;
  const float values[ALL_ROWS] = {
      position.x, position.y, position.z, normal.x, normal.y, normal.z, face.x, face.y, face.z, area, 1.0f / std::sqrt(area),
      map.x,      map.y,      map.z,      map.w};
  reserve(count_ + 1);
  Row *const rows = &row(count_ / block_lanes, 0);
  for (int i = 0; i < rows_; ++i) rows[i].lane[count_ % block_lanes] = values[i];
  ++count_;
}

void Samples::append(const Samples &other, int32_t begin, int32_t end) {
  reserve(count_ + end - begin);
  for (; begin < end; ++begin, ++count_) {
    const Row *const from = &other.row(begin / block_lanes, 0);
    Row *const to = &row(count_ / block_lanes, 0);
    for (int i = 0; i < rows_; ++i) to[i].lane[count_ % block_lanes] = from[i].lane[begin % block_lanes];
  }
}

void Samples::fill_block() {
  if (count_ % block_lanes == 0) return;
  Row *const rows = &row(count_ / block_lanes, 0);
  const int last = (count_ - 1) % block_lanes;
  for (int i = 0; i < rows_; ++i) std::fill(rows[i].lane + last + 1, rows[i].lane + block_lanes, rows[i].lane[last]);
  std::fill(rows[SAMPLE_AREA].lane + last + 1, rows[SAMPLE_AREA].lane + block_lanes, 0.0f);
}

static float largest(const kernels::Lanes &lanes) {
  using Halves = std::array<std::array<float, block_lanes / 2>, 2>;
  const auto [low, high] = std::bit_cast<Halves>(lanes);
  float result = low[0];
  for (size_t i = 0; i < block_lanes / 2; ++i) result = std::max({result, low[i], high[i]});
  return result;
}

vec4 Samples::sphere(int32_t block) const {
  using kernels::Lanes;
  const auto lanes = [&](int r) { return std::bit_cast<Lanes>(row(block, r)); };
  const Lanes x = lanes(SAMPLE_X), y = lanes(SAMPLE_Y), z = lanes(SAMPLE_Z);
  const auto middle = [](const Lanes &v) { return 0.25f * ((v.lane[1] + v.lane[6]) + (v.lane[10] + v.lane[15])); };
  const vec3 at(middle(x), middle(y), middle(z));
  const Lanes dx = x - at.x, dy = y - at.y, dz = z - at.z;
  return vec4(at, std::sqrt(largest(dx * dx + dy * dy + dz * dz)) - 0.5f / largest(-lanes(SAMPLE_PER_SIDE)));
}

void BlockSet::add(int32_t block, vec4 sphere, float radius) {
  const auto at = static_cast<size_t>(count_++);
  if (at % block_lanes == 0) {
    block_.resize(std::max(block_.size(), at + block_lanes));
    for (std::vector<float> *list : {&middle_[0], &middle_[1], &middle_[2], &limit_})
      list->resize(std::max(list->size(), at + block_lanes));
    std::fill_n(limit_.begin() + static_cast<ptrdiff_t>(at), block_lanes, -1.0f);
  }
  block_[at] = block;
  for (int axis = 0; axis < 3; ++axis) middle_[axis][at] = sphere[axis];
  const float limit = radius + sphere.w;
  limit_[at] = limit * limit;
}

SampleBlocks BlockSet::of(const Samples &samples) const {
  return {samples.data(), samples.stride(),
          block_.data(),  {middle_[0].data(), middle_[1].data(), middle_[2].data()},
          limit_.data(),  count_};
}

} // namespace paradesc
