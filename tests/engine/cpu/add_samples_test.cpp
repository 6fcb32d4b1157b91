// Sums over samples: the same bits by every set of instructions that this processor has.
#include "engine/cpu/add_samples.h"

#include <algorithm>
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
std::vector<FlatSample> sheet(int side, Height height) {
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
  std::vector<FlatSample> samples;
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const int a = i * (side + 1) + k, b = a + side + 1;
      for (const auto &[p, q, r] : {std::array{a, b, b + 1}, std::array{a, b + 1, a + 1}}) {
        const vec3 corners[] = {position[p], position[q], position[r]}, normals[] = {normal[p], normal[q], normal[r]};
        const float value = (i + k) % 17 == 0 ? std::nanf("") : unit(random);
        samples.push_back(flat(sample_of_triangle(corners, normals, 0.1f), i * side + k,
                               vec4(unit(random), unit(random), unit(random), value)));
      }
    }
  return samples;
}

float flat_height(float, float) { return 0.0f; }
float bent(float x, float y) { return -1.5f * x * x + y * y; }

struct Summed {
  alignas(64) Sums sums = {};
  std::vector<uint16_t> nearest;
};

Summed sum_up(const SumTarget &target, int kind, const EvaluateParams &params, const std::vector<FlatSample> &samples,
              const SumCenters &centers) {
  std::vector<const FlatSample *> all;
  for (const FlatSample &sample : samples) all.push_back(&sample);
  const std::vector<uint16_t> shown(samples.size(), 0xffff);
  Summed summed;
  summed.nearest.resize(samples.size());
  target.by_kind[kind](params, all.data(), shown.data(), static_cast<int32_t>(all.size()), centers, summed.sums,
                       summed.nearest.data());
  return summed;
}

// Along a line from the first place, so many units of the radius apart.
SumCenters centers_from(vec3 place, vec3 step) {
  SumCenters centers{};
  for (int lane = 0; lane < max_lanes; ++lane)
    for (int axis = 0; axis < 3; ++axis) {
      centers.position[axis][lane] = place[axis] + static_cast<float>(lane) * step[axis];
      centers.normal[axis][lane] = axis == 2 ? 1.0f : 0.0f;
    }
  return centers;
}

EvaluateParams params() {
  EvaluateParams params{};
  params.radius = params.map_radius = radius;
  params.variate_share = 1.0f;
  params.map_sigma = 0.5f * radius;
  return params;
}

TEST(AddSamples, has_the_same_bits_by_every_set_of_instructions) {
  const std::vector<FlatSample> samples = sheet(24, bent);
  const SumCenters centers = centers_from(vec3(0.01f, -0.02f, 0.0f), vec3(0.003f, 0.004f, 0.001f));
  const std::vector<SumTarget> targets = sum_targets();
  ASSERT_FALSE(targets.empty());
  for (int kind = 0; kind < sum_kinds; ++kind) {
    const Summed first = sum_up(targets[0], kind, params(), samples, centers);
    EXPECT_GT(first.sums[0][0], 0.0f) << "the area";
    for (const SumTarget &target : targets) {
      const Summed other = sum_up(target, kind, params(), samples, centers);
      EXPECT_EQ(other.nearest, first.nearest) << target.name;
      EXPECT_EQ(std::memcmp(other.sums, first.sums, sizeof first.sums), 0) << "kind " << kind << " by " << target.name;
    }
  }
}

// Whatever the others are, and whichever samples are far from it.
TEST(AddSamples, has_the_same_bits_whichever_centers_are_beside_one) {
  const std::vector<FlatSample> samples = sheet(24, bent);
  SumCenters centers = centers_from(vec3(0.01f, -0.02f, 0.0f), vec3(0.003f, 0.004f, 0.001f));
  const Summed together = sum_up(sum_targets()[0], 1, params(), samples, centers);
  for (int axis = 0; axis < 3; ++axis) std::fill_n(centers.position[axis], max_lanes, centers.position[axis][max_lanes - 1]);
  std::vector<FlatSample> near;
  for (const FlatSample &sample : samples) {
    float square = 0.0f;
    for (int axis = 0; axis < 3; ++axis) square += std::pow(sample.position[axis] - centers.position[axis][0], 2.0f);
    if (square < std::pow(radius + sample.reach, 2.0f)) near.push_back(sample);
  }
  ASSERT_LT(near.size(), samples.size());
  const Summed alone = sum_up(sum_targets()[0], 1, params(), near, centers);
  for (size_t i = 0; i < max_sums; ++i) EXPECT_EQ(alone.sums[i][0], together.sums[i][max_lanes - 1]) << i;
}

// A plane at some height cuts a disk out of the ball: r^2 - h^2 instead of r^2, and its square in the second moments.
TEST(AddSamples, cuts_triangles_as_the_ball_does) {
  for (const int side : {12, 16, 40}) // some 56, 100 and 630 triangles in the ball
    for (const float height : {0.0f, 0.3f, 0.8f}) {
      const SumCenters centers = centers_from(vec3(0.0f, 0.0f, height * radius), vec3(0.002f, -0.001f, 0.0f));
      const Summed found = sum_up(sum_targets()[0], 0, params(), sheet(side, flat_height), centers);
      const double share = 1.0 - static_cast<double>(height * height),
                   disk = 3.14159265358979 * static_cast<double>(radius * radius);
      for (int lane = 0; lane < max_lanes; ++lane) {
        EXPECT_NEAR(found.sums[0][lane] / disk, share, 2e-4) << side << " at " << height;
        EXPECT_NEAR(found.sums[1][lane] / (0.25 * disk), share * share, 2e-3) << "what varies within cut triangles is estimated";
        EXPECT_NEAR(found.sums[2][lane] / (0.25 * disk), 0.0, 2e-3);
        EXPECT_NEAR(found.sums[3][lane] / (0.25 * disk), share * share, 2e-3);
      }
    }
}

// Another sheet, as far as there may be, is nearest to the center somewhere.
TEST(AddSamples, sees_that_another_sheet_comes_nearest) {
  const SumCenters centers = centers_from(vec3(0.0f), vec3(0.0f, 0.0f, 0.95f / 15.0f * radius));
  const Summed found = sum_up(sum_targets()[0], 0, params(), sheet(24, bent), centers);
  for (int lane = 0; lane < max_lanes; ++lane) {
    const auto nearest = std::ranges::count_if(found.nearest, [&](uint16_t bits) { return (bits >> lane & 1) != 0; });
    EXPECT_GE(nearest, 1) << "of a sheet at " << centers.position[2][lane];
    if (lane == 0) {
      EXPECT_LE(nearest, 24) << "those around the center";
    }
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
