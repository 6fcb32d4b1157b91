// Converts vectors to plain floats, outside of the files that are compiled per instruction set.
#include "engine/cpu/samples.h"

#include <algorithm>
#include <limits>

namespace paradesc {

FlatSample flat(const Sample &sample, int32_t surfel) {
  FlatSample to{};
  const auto copy = [](vec3 from, float *floats) { std::copy_n(&from.x, 3, floats); };
  copy(sample.position, to.position);
  copy(sample.normal, to.normal);
  copy(sample.face, to.face);
  for (int k = 0; k < 2; ++k) {
    copy(sample.along[k], to.along[k]);
    copy(sample.normal_along[k], to.normal_along[k]);
  }
  to.area = sample.area;
  to.reach = sample.reach;
  to.turn = sample.turn;
  to.noise = sample.noise;
  to.facet = sample.facet;
  to.surfel = surfel;
  return to;
}

std::array<vec3, 3> corners_of(const FlatSample &sample, vec3 center) {
  const auto vector = [](const float *v) { return vec3(v[0], v[1], v[2]); };
  const vec3 first = 1.41421356f * vector(sample.along[0]), second = 2.44948974f * vector(sample.along[1]);
  const vec3 offset = vector(sample.position) - center;
  return {offset - 2.0f * first, offset + first + second, offset + first - second};
}

SampleBlock block_of(std::span<const FlatSample> samples) {
  SampleBlock block;
  constexpr float nowhere = 1e18f;
  std::fill_n(&block.corner[0][0][0], sizeof block.corner / sizeof(float), nowhere);
  for (auto *column : {block.face[0], block.face[1], block.face[2], block.turn, block.reach, block.normal[0], block.normal[1],
                       block.normal[2], block.area, block.noise, block.facet})
    std::fill_n(column, block_lanes, 0.0f);
  std::fill_n(&block.turning[0][0], 6 * block_lanes, 0.0f);
  for (size_t i = 0; i < samples.size(); ++i) {
    const std::array<vec3, 3> corners = corners_of(samples[i], vec3(0.0f));
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t k = 0; k < 3; ++k) block.corner[k][axis][i] = corners[k][axis];
      block.face[axis][i] = samples[i].face[axis];
      block.normal[axis][i] = samples[i].normal[axis];
    }
    block.area[i] = samples[i].area;
    block.noise[i] = samples[i].noise;
    block.facet[i] = samples[i].facet;
    const auto turning = [&](int a, int b) {
      float sum = 0.0f;
      for (int k = 0; k < 2; ++k) sum += samples[i].along[k][a] * samples[i].normal_along[k][b];
      return samples[i].area * sum;
    };
    for (int axis = 0; axis < 3; ++axis) block.turning[axis][i] = turning(axis, axis);
    block.turning[3][i] = turning(0, 1) + turning(1, 0);
    block.turning[4][i] = turning(0, 2) + turning(2, 0);
    block.turning[5][i] = turning(1, 2) + turning(2, 1);
    block.turn[i] = samples[i].turn;
    block.reach[i] = samples[i].reach;
  }
  return block;
}

vec4 sphere_of(std::span<const FlatSample> samples) {
  vec3 low(std::numeric_limits<float>::max()), high(-low);
  const auto position = [](const FlatSample &sample) { return vec3(sample.position[0], sample.position[1], sample.position[2]); };
  for (const FlatSample &sample : samples) {
    low = glm::min(low, position(sample) - sample.reach);
    high = glm::max(high, position(sample) + sample.reach);
  }
  const vec3 middle = 0.5f * (low + high);
  float radius = 0.0f;
  for (const FlatSample &sample : samples) radius = std::max(radius, length(position(sample) - middle) + sample.reach);
  return vec4(middle, 1.00001f * radius);
}

} // namespace paradesc
