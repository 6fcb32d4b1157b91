// Sums over samples: the same bits by every set of instructions that this processor has.
#include "engine/cpu/add_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "engine/cpu/ball_edges.h"
#include "engine/cpu/samples.h"

#include "shared.h"

namespace paradesc::test {
namespace {

constexpr float radius = 0.1f;

using Height = float (*)(float x, float y);

// Triangles of a sheet over the square |x|, |y| < 1.5 r, irregular ones; some have a map that does not exist.
SampleList sheet(int side, Height height) {
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
  SampleList samples;
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const int a = i * (side + 1) + k, b = a + side + 1;
      for (const auto &[p, q, r] : {std::array{a, b, b + 1}, std::array{a, b + 1, a + 1}}) {
        const vec3 corners[] = {position[p], position[q], position[r]}, normals[] = {normal[p], normal[q], normal[r]};
        const float value = (i + k) % 17 == 0 ? std::nanf("") : unit(random);
        samples.sample.push_back(flat(sample_of_triangle(corners, normals, 0.1f), i * side + k));
        SampleMap map{{unit(random), unit(random), unit(random), value}, {}};
        for (auto &along : map.along)
          for (float &component : along) component = 0.1f * unit(random);
        samples.map.push_back(map);
      }
    }
  return samples;
}

float flat_height(float, float) { return 0.0f; }
float bent(float x, float y) { return -1.5f * x * x + y * y; }

struct Summed {
  std::array<float, max_sums> sums{};
  std::vector<int32_t> whole, cut, nearest; // samples
};

Summed sum_up(const SumTarget &target, int kind, const EvaluateParams &params, const SampleList &list, const SumCenter &center) {
  const UnsetVector<FlatSample> &samples = list.sample;
  std::vector<SampleBlock> blocks;
  std::vector<float> spheres[4];
  for (size_t first = 0; first < samples.size(); first += block_lanes) {
    const auto of_block = std::span(samples).subspan(first, std::min<size_t>(block_lanes, samples.size() - first));
    blocks.push_back(block_of(of_block));
    const vec4 sphere = sphere_of(of_block);
    for (int i = 0; i < 4; ++i) spheres[i].push_back(sphere[i]);
  }
  std::vector<const SampleBlock *> listed;
  for (const SampleBlock &block : blocks) listed.push_back(&block);
  while (spheres[0].size() % block_lanes != 0)
    for (auto &column : spheres) column.push_back(1e18f);
  std::fill(spheres[3].begin() + static_cast<ptrdiff_t>(blocks.size()), spheres[3].end(), 0.0f);
  Summed summed;
  std::vector<BlockPart> parts(blocks.size());
  for (auto *indices : {&summed.cut, &summed.nearest}) indices->resize(blocks.size() * block_lanes);
  Selection selection{parts.data(), summed.cut.data(), summed.nearest.data(), 0, 0, 0};
  target.select({listed.data(),
                 {spheres[0].data(), spheres[1].data(), spheres[2].data(), spheres[3].data()},
                 static_cast<int32_t>(spheres[0].size())},
                center.position, params.radius, selection);
  parts.resize(static_cast<size_t>(selection.wholes));
  summed.cut.resize(static_cast<size_t>(selection.cuts));
  summed.nearest.resize(static_cast<size_t>(selection.nearests));
  for (const BlockPart &part : parts)
    for (int32_t i = 0; i < block_lanes; ++i)
      if ((part.samples >> i & 1) != 0) summed.whole.push_back(part.block * block_lanes + i);
  const auto filled = [](const auto &from, const std::vector<int32_t> &indices, const auto &nothing) {
    std::vector<decltype(&nothing)> all;
    for (const int32_t i : indices) all.push_back(&from[static_cast<size_t>(i)]);
    while (all.size() % block_lanes != 0) all.push_back(&nothing);
    return all;
  };
  const FlatSample nothing{};
  const SampleMap no_map{};
  const auto whole = filled(samples, summed.whole, nothing), cut = filled(samples, summed.cut, nothing);
  const auto whole_map = filled(list.map, summed.whole, no_map), cut_map = filled(list.map, summed.cut, no_map);
  const auto blocks_of = [](const auto &all) { return static_cast<int32_t>(all.size()) / block_lanes; };
  target.by_kind[kind](
      params,
      {parts, listed.data(), {whole.data(), whole_map.data(), blocks_of(whole)}, {cut.data(), cut_map.data(), blocks_of(cut)}},
      center, summed.sums.data());
  return summed;
}

SumCenter center_at(vec3 place) { return {{place.x, place.y, place.z}, {0.0f, 0.0f, 1.0f}, 0.25f}; }

EvaluateParams params() {
  EvaluateParams params{};
  params.radius = params.map_radius = radius;
  params.variate_share = 1.0f;
  params.map_sigma = 0.5f * radius;
  return params;
}

TEST(AddSamples, has_the_same_bits_by_every_set_of_instructions) {
  const SampleList samples = sheet(24, bent);
  const SumCenter center = center_at(vec3(0.013f, -0.016f, 0.001f));
  const std::vector<SumTarget> targets = sum_targets();
  ASSERT_FALSE(targets.empty());
  for (int kind = 0; kind < sum_kinds; ++kind) {
    const Summed first = sum_up(targets[0], kind, params(), samples, center);
    EXPECT_GT(first.sums[0], 0.0f) << "the area";
    for (const SumTarget &target : targets) {
      const Summed other = sum_up(target, kind, params(), samples, center);
      EXPECT_EQ(other.whole, first.whole) << target.name;
      EXPECT_EQ(other.cut, first.cut) << target.name;
      EXPECT_EQ(other.nearest, first.nearest) << target.name;
      EXPECT_EQ(std::memcmp(&other.sums, &first.sums, sizeof first.sums), 0) << "kind " << kind << " by " << target.name;
    }
  }
}

TEST(AddSamples, has_the_same_bits_whichever_samples_outside_the_ball_are_looked_at) {
  const SampleList samples = sheet(24, bent);
  const SumCenter center = center_at(vec3(0.013f, -0.016f, 0.001f));
  SampleList near; // of whole blocks, in which samples have places
  for (size_t first = 0; first < samples.sample.size(); first += block_lanes) {
    const size_t last = std::min<size_t>(first + block_lanes, samples.sample.size());
    const bool any = std::any_of(&samples.sample[first], &samples.sample[0] + last, [&](const FlatSample &sample) {
      float square = 0.0f;
      for (int axis = 0; axis < 3; ++axis) square += std::pow(sample.position[axis] - center.position[axis], 2.0f);
      return square < std::pow(radius + sample.reach, 2.0f);
    });
    for (size_t i = first; any && i < last; ++i) {
      near.sample.push_back(samples.sample[i]);
      near.map.push_back(samples.map[i]);
    }
  }
  ASSERT_LT(near.sample.size(), samples.sample.size());
  for (const SumTarget &target : sum_targets())
    for (int kind = 0; kind < sum_kinds; ++kind)
      EXPECT_EQ(sum_up(target, kind, params(), near, center).sums, sum_up(target, kind, params(), samples, center).sums) << kind;
}

// Each sample that lies in the ball, once, by itself.
TEST(AddSamples, takes_what_lies_in_the_ball) {
  const SampleList samples = sheet(24, bent);
  const SumCenter center = center_at(vec3(0.013f, -0.016f, 0.001f));
  std::vector<int32_t> whole, cut;
  for (size_t i = 0; i < samples.sample.size(); ++i) {
    int inside = 0;
    for (const vec3 &corner : corners_of(samples.sample[i], vec3(center.position[0], center.position[1], center.position[2])))
      inside += dot(corner, corner) < radius * radius ? 1 : 0;
    if (inside > 0) (inside == 3 ? whole : cut).push_back(static_cast<int32_t>(i));
  }
  ASSERT_GT(whole.size(), 100u);
  for (const SumTarget &target : sum_targets()) {
    const Summed found = sum_up(target, 0, params(), samples, center);
    EXPECT_EQ(found.whole, whole) << target.name;
    EXPECT_EQ(found.cut, cut) << target.name;
  }
}

// A plane at some height cuts a disk out of the ball: r^2 - h^2 instead of r^2, and its square in the second moments.
TEST(AddSamples, cuts_triangles_as_the_ball_does) {
  for (const int side : {12, 16, 40}) // some 56, 100 and 630 triangles in the ball
    for (const float height : {0.0f, 0.3f, 0.8f}) {
      const SampleList samples = sheet(side, flat_height);
      const double share = 1.0 - static_cast<double>(height * height),
                   disk = 3.14159265358979 * static_cast<double>(radius * radius);
      for (int i = 0; i < 16; ++i) {
        const vec3 place(0.002f * static_cast<float>(i), -0.001f * static_cast<float>(i), height * radius);
        const Summed found = sum_up(sum_targets()[0], 0, params(), samples, center_at(place));
        EXPECT_NEAR(found.sums[0] / disk, share, 2e-4) << side << " at " << height;
        EXPECT_NEAR(found.sums[1] / (0.25 * disk), share * share, 2e-3) << "what varies within cut triangles is estimated";
        EXPECT_NEAR(found.sums[2] / (0.25 * disk), 0.0, 2e-3);
        EXPECT_NEAR(found.sums[3] / (0.25 * disk), share * share, 2e-3);
      }
    }
}

// Another sheet, as far as there may be, is nearest to the center somewhere.
TEST(AddSamples, sees_that_another_sheet_comes_nearest) {
  const SampleList samples = sheet(24, bent);
  for (int i = 0; i < 16; ++i) {
    const vec3 place(0.0f, 0.0f, 0.95f / 15.0f * radius * static_cast<float>(i));
    const size_t nearest = sum_up(sum_targets()[0], 0, params(), samples, center_at(place)).nearest.size();
    EXPECT_GE(nearest, 1u) << "of a sheet at " << place.z;
    if (i == 0) {
      EXPECT_LE(nearest, 24u) << "those around the center";
    }
  }
}

// One flipped triangle lets a sample lean from its face without bounds: still the surface comes nowhere near from beyond the rim.
TEST(AddSamples, sees_nothing_near_in_what_leans_beyond_the_rim) {
  SampleList samples = sheet(24, flat_height);
  for (FlatSample &sample : samples.sample) sample.turn = 1e6f;
  const vec3 center(0.0f, 0.0f, 0.9f * radius);
  const std::vector<int32_t> nearest = sum_up(sum_targets()[0], 0, params(), samples, center_at(center)).nearest;
  EXPECT_FALSE(nearest.empty());
  for (const int32_t i : nearest) {
    const FlatSample &sample = samples.sample[static_cast<size_t>(i)];
    EXPECT_LT(length(vec3(sample.position[0], sample.position[1], sample.position[2]) - center), radius + sample.reach);
  }
}

// By every set of instructions what BallEdges tells of one ball: edges within, through, beside and beyond balls, and points.
TEST(BallsOfEdge, are_those_that_the_edge_meets) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const auto point = [&] { return vec3(unit(random), unit(random), unit(random)); };
  Balls balls{};
  balls.count = 41;
  balls.radius = 0.5f;
  for (int i = 0; i < balls.count; ++i)
    for (auto &column : balls.center) column[i] = unit(random);
  size_t met = 0;
  for (int round = 0; round < 200; ++round) {
    const vec3 from = point(), to = round % 10 == 0 ? from : from + 0.01f * static_cast<float>(round) * point();
    for (const SumTarget &target : sum_targets()) {
      const uint64_t found = target.balls_of_edge(balls, &from.x, &to.x);
      for (int i = 0; i < balls.count; ++i) {
        const vec3 center(balls.center[0][i], balls.center[1][i], balls.center[2][i]);
        const bool meets = meets_ball(from - center, to - center, balls.radius);
        EXPECT_EQ((found >> i & 1) != 0, meets) << target.name;
        met += meets ? 1 : 0;
      }
    }
  }
  EXPECT_GT(met, 0u);
}

TEST(Pieces, of_a_cluster_have_the_moments_of_their_triangles) {
  const vec3 corners[] = {{0.0f, 0.0f, 0.0f}, {3.0f, 0.0f, 0.0f}, {1.0f, 2.0f, 0.0f}, {4.0f, 2.5f, 0.0f}};
  const auto normal = [](vec3 p) { return normalize(vec3(0.02f * p.x, -0.01f * p.y + 0.01f * p.x, 1.0f)); };
  const auto triangle = [&](int a, int b, int c) {
    const vec3 p[] = {corners[a], corners[b], corners[c]}, n[] = {normal(p[0]), normal(p[1]), normal(p[2])};
    return sample_of_triangle(p, n);
  };
  ClusterSums sums(corners[0]);
  sums.add(triangle(0, 1, 2));
  sums.add(triangle(1, 3, 2));
  const Cluster whole = sums.cluster();
  const Sample sample = sample_of(whole, 0.01f);
  EXPECT_FLOAT_EQ(sample.area, 3.0f + 3.5f);
  ClusterSums of_sample(corners[3]);
  of_sample.add(sample);
  const Cluster again = of_sample.cluster();
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
