// Blocks are written once and read by lanes.
#include "engine/cpu/samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#define LANE_WIDTH 16
#define KERNEL_TARGET blocks
#include "engine/kernels/lanes.h"

namespace paradesc {

void Samples::clear(bool with_map) {
  const int32_t rows = with_map ? ALL_ROWS : SURFACE_ROWS;
  if (std::exchange(rows_, rows) != rows) room_ = 0;
  count_ = 0;
}

void Samples::grow(int32_t count) {
  const int32_t blocks = (count + count / 2) / block_lanes + 1;
  auto grown = std::make_unique_for_overwrite<Row[]>(static_cast<size_t>(blocks) * static_cast<size_t>(rows_));
  if (count_ > 0) std::copy_n(rows_of(0), this->blocks() * rows_, grown.get());
  rows_of_blocks_ = std::move(grown);
  room_ = blocks * block_lanes;
}

void Samples::add(const Sample &sample, vec4 map) {
  reserve(count_ + 1);
  float *to = rows_of(count_ / block_lanes)->lane + count_ % block_lanes;
  const auto put = [&](float value) {
    *to = value;
    to += block_lanes;
  };
  for (const vec3 &v : {sample.position, sample.along[0], sample.along[1], sample.normal, sample.normal_along[0],
                        sample.normal_along[1], sample.face})
    for (int axis = 0; axis < 3; ++axis) put(v[axis]);
  for (const float value : {sample.area, 1.0f / sample.area, sample.reach, sample.turn}) put(value);
  if (rows_ != ALL_ROWS) return void(++count_);
  for (int i = 0; i < 4; ++i) put(map[i]);
  ++count_;
}

void Samples::append(const Samples &other, int32_t begin, int32_t end) {
  reserve(count_ + end - begin);
  for (; begin < end; ++begin, ++count_) {
    const Row *const from = other.rows_of(begin / block_lanes);
    Row *const to = rows_of(count_ / block_lanes);
    for (int i = 0; i < rows_; ++i) to[i].lane[count_ % block_lanes] = from[i].lane[begin % block_lanes];
  }
}

void Samples::fill_block() {
  if (count_ % block_lanes == 0) return;
  Row *const rows = rows_of(count_ / block_lanes);
  const int last = (count_ - 1) % block_lanes;
  for (int i = 0; i < rows_; ++i) std::fill(rows[i].lane + last + 1, rows[i].lane + block_lanes, rows[i].lane[last]);
  std::fill(rows[SAMPLE_AREA].lane + last + 1, rows[SAMPLE_AREA].lane + block_lanes, 0.0f);
}

void Samples::resize_blocks(int32_t blocks) {
  reserve(blocks * block_lanes);
  count_ = blocks * block_lanes;
}

void Samples::copy_blocks(const Samples &other, int32_t block) {
  if (other.blocks() > 0) std::copy_n(other.rows_of(0), other.blocks() * rows_, rows_of(block));
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
  const auto lanes = [&](int r) { return std::bit_cast<Lanes>(rows_of(block)[r]); };
  const Lanes x = lanes(SAMPLE_POSITION), y = lanes(SAMPLE_POSITION + 1), z = lanes(SAMPLE_POSITION + 2);
  const auto middle = [](const Lanes &v) { return 0.25f * ((v.lane[1] + v.lane[6]) + (v.lane[10] + v.lane[15])); };
  const vec3 at(middle(x), middle(y), middle(z));
  const Lanes dx = x - at.x, dy = y - at.y, dz = z - at.z;
  return vec4(at, 1.00001f * (std::sqrt(largest(dx * dx + dy * dy + dz * dz)) + largest(lanes(SAMPLE_REACH))));
}

static constexpr uint16_t all_shown = 0xffff;

void BlockSet::add(int32_t block, vec4 sphere, float radius) {
  const auto at = static_cast<size_t>(count_++);
  if (at % block_lanes == 0) {
    block_.resize(std::max(block_.size(), at + block_lanes));
    shown_.resize(block_.size());
    taken_.resize(block_.size());
    for (std::vector<float> *list : {&middle_[0], &middle_[1], &middle_[2], &limit_})
      list->resize(std::max(list->size(), at + block_lanes));
    std::fill_n(limit_.begin() + static_cast<ptrdiff_t>(at), block_lanes, -1.0f);
  }
  block_[at] = block;
  shown_[at] = all_shown;
  taken_[at] = 0;
  for (int axis = 0; axis < 3; ++axis) middle_[axis][at] = sphere[axis];
  const float limit = radius + sphere.w;
  limit_[at] = limit * limit;
}

SampleBlocks BlockSet::of(const Samples &samples) const {
  return {samples.data(),
          samples.stride(),
          block_.data(),
          shown_.data(),
          {middle_[0].data(), middle_[1].data(), middle_[2].data()},
          limit_.data(),
          count_};
}

void BlockSet::take(int32_t begin, int32_t end) {
  if (begin >= end) return;
  size_t at =
      static_cast<size_t>(std::lower_bound(block_.begin(), block_.begin() + count_, begin / block_lanes) - block_.begin());
  for (; at < static_cast<size_t>(count_) && block_[at] * block_lanes < end; ++at) {
    const int32_t from = std::max(begin - block_[at] * block_lanes, 0),
                  to = std::min(end - block_[at] * block_lanes, block_lanes);
    taken_[at] = static_cast<uint16_t>(taken_[at] | ((1u << to) - (1u << from)));
  }
}

void BlockSet::hide_rest() {
  std::swap(shown_, taken_);
  std::fill_n(taken_.begin(), count_, uint16_t{0});
}

void BlockSet::show_all() { std::fill_n(shown_.begin(), count_, all_shown); }

} // namespace paradesc
