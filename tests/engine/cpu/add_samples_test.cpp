// Sums over samples: the same bits by every set of instructions that this processor has.
#include "engine/cpu/add_samples.h"

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "engine/cpu/samples.h"

#include "shared.h"

namespace paradesc::test {
namespace {

constexpr float radius = 0.1f;

using Height = float (*)(float x, float y);

// Triangles of a sheet over the square |x|, |y| < 1.5 r, irregular ones; some have a map that does not exist.
Samples sheet(int side, Height height) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const float step = 3.0f * radius / static_cast<float>(side);
  std::vector<vec3> position, normal;
  for (int i = 0; i <= side; ++i)
    for (int k = 0; k <= side; ++k) {
      const float x = static_cast<float>(i) * step - 1.5f * radius + 0.2f * step * unit(random);
      const float y = static_cast<float>(k) * step - 1.5f * radius + 0.2f * step * unit(random);
      constexpr float d = 1e-3f;
      position.emplace_back(x, y, height(x, y));
      normal.push_back(normalize(
          vec3((height(x - d, y) - height(x + d, y)) / (2.0f * d), (height(x, y - d) - height(x, y + d)) / (2.0f * d), 1.0f)));
    }
  Samples samples;
  samples.clear(true);
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const int a = i * (side + 1) + k, b = a + side + 1;
      for (const auto &[p, q, r] : {std::array{a, b, b + 1}, std::array{a, b + 1, a + 1}}) {
        const vec3 corners[] = {position[p], position[q], position[r]}, normals[] = {normal[p], normal[q], normal[r]};
        const float value = (i + k) % 17 == 0 ? std::nanf("") : unit(random);
        samples.add(sample_of_triangle(corners, normals, 0.1f), vec4(unit(random), unit(random), unit(random), value));
      }
    }
  samples.fill_block();
  return samples;
}

float flat(float, float) { return 0.0f; }
float bent(float x, float y) { return -1.5f * x * x + y * y; }

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
  const Samples samples = sheet(24, bent);
  const BlockSet blocks = all_blocks(samples);
  const SumCenter center{{0.01f, -0.02f, 0.0f}, {0.03f, 0.04f, std::sqrt(1.0f - 0.0025f)}, 0.3f};
  const std::vector<SumTarget> targets = sum_targets();
  ASSERT_FALSE(targets.empty());
  for (int kind = 0; kind < sum_kinds; ++kind) {
    float first[max_sums] = {};
    const int32_t nearest = targets[0].by_kind[kind](params(), blocks.of(samples), center, first);
    EXPECT_GT(first[0], 0.0f) << "the area";
    for (const SumTarget &target : targets) {
      float sums[max_sums] = {};
      EXPECT_EQ(target.by_kind[kind](params(), blocks.of(samples), center, sums), nearest) << target.name;
      EXPECT_EQ(std::memcmp(sums, first, sizeof sums), 0) << "kind " << kind << " by " << target.name;
      EXPECT_EQ(target.count_nearest(radius, samples.data(), samples.stride(), 0, samples.count(), center), nearest);
    }
  }
}

struct Cut {
  double area, xx, xy, yy; // over those of a disk of the radius
};

Cut cut(const Samples &samples, const SumCenter &center) {
  const BlockSet blocks = all_blocks(samples);
  float sums[max_sums] = {};
  sum_targets()[0].by_kind[0](params(), blocks.of(samples), center, sums);
  const double disk = 3.14159265358979 * static_cast<double>(radius * radius);
  return {sums[0] / disk, sums[1] / (0.25 * disk), sums[2] / (0.25 * disk), sums[3] / (0.25 * disk)};
}

// A plane at some height cuts a disk out of the ball: r^2 - h^2 instead of r^2, and its square in the second moments.
TEST(AddSamples, cuts_triangles_as_the_ball_does) {
  for (const int side : {12, 16, 40}) // some 56, 100 and 630 triangles in the ball
    for (const float height : {0.0f, 0.3f, 0.8f})
      for (const float x : {0.0f, 0.013f, 0.027f}) {
        const Cut found = cut(sheet(side, flat), {{x, -0.5f * x, height * radius}, {0.0f, 0.0f, 1.0f}, 0.0f});
        const double share = 1.0 - static_cast<double>(height * height);
        EXPECT_NEAR(found.area, share, 2e-4) << side << " at " << height;
        EXPECT_NEAR(found.xx, share * share, 2e-3) << "what varies within cut triangles is estimated";
        EXPECT_NEAR(found.yy, share * share, 2e-3);
        EXPECT_NEAR(found.xy, 0.0, 2e-3);
      }
}

// Another sheet, as far as there may be, is nearest to the center somewhere.
TEST(AddSamples, sees_that_another_sheet_comes_nearest) {
  const Samples samples = sheet(24, bent);
  const auto nearest = [](const Samples &of, const SumCenter &center) {
    const BlockSet blocks = all_blocks(of);
    float sums[max_sums] = {};
    return sum_targets()[0].by_kind[0](params(), blocks.of(of), center, sums);
  };
  const int32_t alone = nearest(samples, {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0.0f});
  EXPECT_GE(alone, 1);
  EXPECT_LE(alone, 24) << "those around the center";
  for (const float height : {0.05f, 0.5f, 0.95f}) {
    const int32_t other = nearest(samples, {{0.0f, 0.0f, height * radius}, {0.0f, 0.0f, 1.0f}, 0.0f});
    EXPECT_GE(other, 1) << "of a sheet at " << height << " of the radius";
  }
}

TEST(Pieces, of_a_cluster_have_the_moments_of_their_triangles) {
  const vec3 corners[] = {{0.0f, 0.0f, 0.0f}, {3.0f, 0.0f, 0.0f}, {1.0f, 2.0f, 0.0f}, {4.0f, 2.5f, 0.0f}};
  const auto normal = [](vec3 p) { return normalize(vec3(0.02f * p.x, -0.01f * p.y + 0.01f * p.x, 1.0f)); };
  const auto triangle = [&](int a, int b, int c) {
    const vec3 p[] = {corners[a], corners[b], corners[c]}, n[] = {normal(p[0]), normal(p[1]), normal(p[2])};
    return sample_of_triangle(p, n, 0.01f);
  };
  const Cluster parts[] = {cluster_of(triangle(0, 1, 2), 0.01f), cluster_of(triangle(1, 3, 2), 0.01f)};
  const Cluster whole = join(parts);
  const Sample sample = sample_of(whole);
  EXPECT_FLOAT_EQ(sample.area, 3.0f + 3.5f);
  const Cluster again = cluster_of(sample, 0.01f);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(again.variance[i][k], whole.variance[i][k], 1e-5f);
      EXPECT_NEAR(again.normal_variance[i][k], whole.normal_variance[i][k], 1e-6f);
    }
  // The mean of x y^T over the quadrilateral, by its triangles' edge middles.
  double variance = 0, mean = 0;
  for (const auto &[a, b, c] : {std::array{0, 1, 2}, std::array{1, 3, 2}}) {
    const double area = a == 0 ? 3.0 : 3.5;
    for (const auto &[p, q] : {std::array{a, b}, std::array{b, c}, std::array{c, a}}) {
      const double x = 0.5 * static_cast<double>(corners[p].x + corners[q].x);
      mean += area / 3 * x / 6.5;
      variance += area / 3 * x * x / 6.5;
    }
  }
  EXPECT_NEAR(whole.position.x, mean, 1e-5);
  EXPECT_NEAR(whole.variance[0][0], variance - mean * mean, 1e-4);
}

} // namespace
} // namespace paradesc::test
