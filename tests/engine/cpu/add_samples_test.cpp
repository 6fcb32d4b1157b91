// Sums over samples: the same bits by every set of instructions that this processor has.
#include "engine/cpu/add_samples.h"

#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "engine/cpu/samples.h"

#include "shared.h"

namespace paradesc::test {
namespace {

constexpr float radius = 0.1f;

// Samples of a bent sheet that reaches beyond the ball, some with a map that does not exist.
Samples random_samples(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  Samples samples;
  samples.clear(true);
  for (int i = 0; i < count; ++i) {
    const float x = 0.15f * unit(random), y = 0.15f * unit(random);
    const vec3 normal = normalize(vec3(3.0f * x + 0.1f * unit(random), -2.0f * y, 1.0f));
    const float value = i % 17 == 0 ? std::nanf("") : unit(random);
    samples.add({vec3(x, y, -1.5f * x * x + y * y), normal, normal, 1e-5f * (2.0f + unit(random)),
                 vec4(unit(random), unit(random), unit(random), value)});
  }
  samples.fill_block();
  return samples;
}

BlockSet all_blocks(const Samples &samples) {
  BlockSet set;
  for (int32_t block = 0; block < samples.blocks(); ++block) set.add(block, samples.sphere(block), radius);
  return set;
}

EvaluateParams params() {
  EvaluateParams params{};
  params.radius = params.map_radius = radius;
  params.variate_share = 1.0f;
  params.map_sigma = 0.5f * radius;
  return params;
}

TEST(AddSamples, has_the_same_bits_by_every_set_of_instructions) {
  const Samples samples = random_samples(1000);
  const BlockSet blocks = all_blocks(samples);
  const SumCenter center{{0.01f, -0.02f, 0.0f}, {0.03f, 0.04f, std::sqrt(1.0f - 0.0025f)}, 0.3f};
  const std::vector<SumTarget> targets = sum_targets();
  ASSERT_FALSE(targets.empty());
  for (int kind = 0; kind < sum_kinds; ++kind) {
    float first[max_sums] = {};
    const float along = targets[0].by_kind[kind](params(), blocks.of(samples), center, first);
    EXPECT_GT(first[0], 0.0f) << "the area";
    for (const SumTarget &target : targets) {
      float sums[max_sums] = {};
      EXPECT_EQ(target.by_kind[kind](params(), blocks.of(samples), center, sums), along) << target.name;
      EXPECT_EQ(std::memcmp(sums, first, sizeof sums), 0) << "kind " << kind << " by " << target.name;
    }
  }
}

TEST(AddSamples, counts_what_lies_in_the_ball) {
  const Samples samples = random_samples(1000);
  const BlockSet blocks = all_blocks(samples);
  float sums[max_sums] = {};
  const SumCenter center{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0.0f};
  sum_targets()[0].by_kind[0](params(), blocks.of(samples), center, sums);
  double area = 0;
  for (int32_t i = 0; i < samples.count(); ++i) {
    const float *const lane = samples.data() + i / block_lanes * samples.stride() + i % block_lanes;
    const auto row = [&](int index) { return static_cast<double>(lane[index * block_lanes]); };
    const double away = std::hypot(row(SAMPLE_X), row(SAMPLE_Y), row(SAMPLE_Z));
    area += row(SAMPLE_AREA) * std::clamp((radius - away) * row(SAMPLE_PER_SIDE) + 0.5, 0.0, 1.0);
  }
  EXPECT_NEAR(sums[0], area, 1e-5 * area) << "floats";
}

// A sheet below, which faces the center: there the distance lies along the normal.
TEST(AddSamples, sees_another_sheet_by_the_way_that_it_lies) {
  Samples samples = random_samples(400);
  const SumCenter center{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0.0f};
  float sums[max_sums] = {};
  const BlockSet alone = all_blocks(samples);
  EXPECT_LT(sum_targets()[0].by_kind[0](params(), alone.of(samples), center, sums), 0.5f);
  samples = random_samples(400);
  Samples with_another;
  with_another.clear(true);
  with_another.append(samples, 0, samples.count());
  with_another.add({vec3(0.0f, 0.001f, -0.09f), vec3(0.0f, 0.0f, -1.0f), vec3(0.0f, 0.0f, -1.0f), 1e-5f, vec4(0.0f)});
  with_another.fill_block();
  const BlockSet both = all_blocks(with_another);
  EXPECT_GT(sum_targets()[0].by_kind[0](params(), both.of(with_another), center, sums), 0.99f);
}

} // namespace
} // namespace paradesc::test
