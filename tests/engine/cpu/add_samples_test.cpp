// Sums over samples, triangles and clusters: what part of them lies in a ball, and the same bits by every set of instructions
// that this processor has.
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
        samples.sample.push_back(flat(sample_of_triangle(corners, normals), false));
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

// Samples of tiles over the same square in the plane: squares, or the triangles that are their halves. A cluster holds one tile.
SampleList tiles(int side, bool are_squares, float angle) {
  const float step = 3.0f * radius / static_cast<float>(side);
  const auto place = [&](int i, int k) {
    const float x = static_cast<float>(i) * step - 1.5f * radius, y = static_cast<float>(k) * step - 1.5f * radius;
    return vec3(std::cos(angle) * x - std::sin(angle) * y, std::sin(angle) * x + std::cos(angle) * y, 0.0f);
  };
  const vec3 normals[] = {{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 1.0f}};
  SampleList samples;
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const vec3 lower[] = {place(i, k), place(i + 1, k), place(i + 1, k + 1)},
                 upper[] = {place(i, k), place(i + 1, k + 1), place(i, k + 1)};
      ClusterSums sums(lower[0]), rest(lower[0]);
      sums.add(sample_of_triangle(lower, normals));
      (are_squares ? sums : rest).add(sample_of_triangle(upper, normals));
      samples.sample.push_back(flat(sample_of(sums.cluster()), true));
      if (!are_squares) samples.sample.push_back(flat(sample_of(rest.cluster()), true));
    }
  samples.map.assign(samples.sample.size(), {});
  return samples;
}

// The same sheet, of which every other pair of triangles is a cluster.
SampleList mixed_sheet(int side, Height height) {
  const SampleList all = sheet(side, height);
  const auto sample = [&](size_t i) {
    const FlatSample &from = all.sample[i];
    const auto vector = [](const float *v) { return vec3(v[0], v[1], v[2]); };
    Sample to;
    to.position = vector(from.position);
    to.normal = vector(from.normal);
    to.face = vector(from.face);
    for (size_t k = 0; k < 2; ++k) {
      to.along[k] = vector(from.along[k]);
      to.normal_along[k] = vector(from.normal_along[k]);
    }
    to.area = from.area;
    return to;
  };
  SampleList mixed;
  for (size_t i = 0; i < all.sample.size(); i += 2) {
    if (i % 4 == 0) {
      for (const size_t k : {i, i + 1}) {
        mixed.sample.push_back(all.sample[k]);
        mixed.map.push_back(all.map[k]);
      }
      continue;
    }
    ClusterSums sums(sample(i).position);
    sums.add(sample(i));
    sums.add(sample(i + 1));
    mixed.sample.push_back(flat(sample_of(sums.cluster()), true));
    mixed.map.push_back(all.map[i]);
  }
  return mixed;
}

// Places of samples in a list: in the ball with all corners, with some, and with none. Clusters that the rim may cut are cut
// ones.
struct Selected {
  std::vector<size_t> whole, cut, outside;
};

Selected select(const SampleList &list, const SumCenter &center) {
  constexpr float root2 = 1.41421356f, root6 = 2.44948974f;
  const auto vector = [](const float *v) { return vec3(v[0], v[1], v[2]); };
  Selected selected;
  for (size_t i = 0; i < list.sample.size(); ++i) {
    const FlatSample &sample = list.sample[i];
    const vec3 offset = vector(sample.position) - vector(center.position), first = root2 * vector(sample.along[0]),
               second = root6 * vector(sample.along[1]);
    int inside = 0;
    for (const vec3 &corner : {offset - 2.0f * first, offset + first + second, offset + first - second})
      inside += dot(corner, corner) < radius * radius ? 1 : 0;
    if (sample.is_cluster > 0.0f) {
      const float reach = 3.0f * std::sqrt(dot(first, first) + dot(second, second));
      inside = length(offset) > radius + reach ? 0 : 1;
    }
    (inside == 0 ? selected.outside : inside == 3 ? selected.whole : selected.cut).push_back(i);
  }
  return selected;
}

using Sums = std::array<float, max_sums>;

Sums sum_up(const SumTarget &target, int kind, const EvaluateParams &params, const SampleList &list, const SumCenter &center,
            const Selected &selected) {
  const FlatSample nothing{};
  const SampleMap no_map{};
  std::vector<const FlatSample *> samples{&nothing};
  std::vector<const SampleMap *> maps{&no_map};
  for (size_t i = 0; i < list.sample.size(); ++i) {
    samples.push_back(&list.sample[i]);
    maps.push_back(&list.map[i]);
  }
  const auto filled = [](const std::vector<size_t> &indices) {
    std::vector<int32_t> items;
    for (const size_t i : indices) items.push_back(static_cast<int32_t>(i) + 1);
    while (items.size() % block_lanes != 0) items.push_back(0);
    return items;
  };
  const std::vector<int32_t> whole = filled(selected.whole), cut = filled(selected.cut);
  const auto run_of = [](const std::vector<int32_t> &items) {
    return SampleRun{items.data(), static_cast<int32_t>(items.size()) / block_lanes};
  };
  Sums sums{};
  target.by_kind[kind](params, {samples.data(), maps.data(), run_of(whole), run_of(cut), true}, center, sums.data());
  return sums;
}

Sums sum_up(const SumTarget &target, int kind, const EvaluateParams &params, const SampleList &list, const SumCenter &center) {
  return sum_up(target, kind, params, list, center, select(list, center));
}

SumCenter center_at(vec3 place) { return {{place.x, place.y, place.z}, {0.0f, 0.0f, 1.0f}, 0.25f}; }

EvaluateParams params() {
  EvaluateParams params{};
  params.radius = params.map_radius = radius;
  params.variate_share = 1.0f;
  params.map_sigma = 0.5f * radius;
  return params;
}

void expect_the_same_bits(const SampleList &samples) {
  const SumCenter center = center_at(vec3(0.013f, -0.016f, 0.001f));
  const std::vector<SumTarget> targets = sum_targets();
  ASSERT_FALSE(targets.empty());
  for (int kind = 0; kind < sum_kinds; ++kind) {
    const Sums first = sum_up(targets[0], kind, params(), samples, center);
    EXPECT_GT(first[0], 0.0f) << "the area";
    for (const SumTarget &target : targets) {
      const Sums other = sum_up(target, kind, params(), samples, center);
      EXPECT_EQ(std::memcmp(&other, &first, sizeof first), 0) << "kind " << kind << " by " << target.name;
    }
  }
}

TEST(AddSamples, has_the_same_bits_by_every_set_of_instructions) { expect_the_same_bits(sheet(24, bent)); }

TEST(AddSamples, has_the_same_bits_by_every_set_of_instructions_for_clusters_among_triangles) {
  const SampleList samples = mixed_sheet(24, bent);
  const auto clusters = std::ranges::count_if(samples.sample, [](const FlatSample &sample) { return sample.is_cluster > 0.0f; });
  ASSERT_GT(clusters, 200);
  ASSERT_LT(static_cast<size_t>(2 * clusters), samples.sample.size());
  expect_the_same_bits(samples);
}

// Each sample keeps its lane: blocks of samples outside come first, and the others last.
TEST(AddSamples, has_the_same_bits_whichever_samples_outside_the_ball_are_looked_at) {
  for (const SampleList &samples : {sheet(24, bent), mixed_sheet(24, bent)}) {
    const SumCenter center = center_at(vec3(0.013f, -0.016f, 0.001f));
    const Selected near = select(samples, center);
    ASSERT_GT(near.outside.size(), 3u * block_lanes);
    Selected all = near;
    all.cut.assign(near.outside.begin(), near.outside.begin() + block_lanes);
    all.cut.insert(all.cut.end(), near.cut.begin(), near.cut.end());
    all.cut.insert(all.cut.end(), near.outside.begin() + block_lanes, near.outside.end());
    for (const SumTarget &target : sum_targets())
      for (int kind = 0; kind < sum_kinds; ++kind)
        EXPECT_EQ(sum_up(target, kind, params(), samples, center, all), sum_up(target, kind, params(), samples, center, near))
            << kind << " by " << target.name;
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
        const Sums found = sum_up(sum_targets()[0], 0, params(), samples, center_at(place));
        EXPECT_NEAR(found[0] / disk, share, 2e-4) << side << " at " << height;
        EXPECT_NEAR(found[1] / (0.25 * disk), share * share, 2e-3) << "what varies within cut triangles is estimated";
        EXPECT_NEAR(found[2] / (0.25 * disk), 0.0, 2e-3);
        EXPECT_NEAR(found[3] / (0.25 * disk), share * share, 2e-3);
      }
    }
}

// A tile that the rim cuts is off by a part of its area, with either sign. So errors are about as large as a few tiles are, of
// which the disk has a third of all: at most 1.7 tiles' share in the area, and 3.9 in the moments, over 64 places and directions.
TEST(AddSamples, has_the_area_and_the_moments_of_a_disk_of_clusters) {
  for (const bool are_squares : {true, false})
    for (const int side : {24, 48}) {
      double worst_area = 0, worst_moment = 0;
      const double disk = 3.14159265358979 * static_cast<double>(radius * radius);
      for (int i = 0; i < 64; ++i) {
        const auto at = static_cast<float>(i);
        const SampleList samples = tiles(side, are_squares, 0.1f * at);
        const vec3 place(0.3f * radius * std::sin(7.0f * at), 0.3f * radius * std::sin(11.0f * at), 0.0f);
        const Sums found = sum_up(sum_targets()[0], 0, params(), samples, center_at(place));
        worst_area = std::max(worst_area, std::abs(found[0] / disk - 1.0));
        for (const size_t k : {1u, 2u, 3u})
          worst_moment = std::max(worst_moment, std::abs(found[k] / (0.25 * disk) - (k == 2 ? 0.0 : 1.0)));
      }
      const double per_tiles = 1.0 / static_cast<double>(side * side);
      EXPECT_LT(worst_area, 2.4 * per_tiles) << "squares: " << are_squares << ", side " << side;
      EXPECT_LT(worst_moment, 6.0 * per_tiles) << "squares: " << are_squares << ", side " << side;
    }
}

// A cluster whose outline is unknown ends where a disk of its variance would, within its half diagonal.
TEST(AddSamples, has_all_of_a_cluster_within_the_ball_and_nothing_of_one_beyond_it) {
  SampleList samples = tiles(24, true, 0.0f);
  samples.sample.resize(1);
  samples.map.resize(1);
  const vec3 middle(samples.sample[0].position[0], samples.sample[0].position[1], 0.0f);
  const float half_diagonal = 1.5f / 24.0f * radius * std::sqrt(2.0f);
  for (const SumTarget &target : sum_targets())
    for (int kind = 0; kind < sum_kinds; ++kind)
      for (int i = 0; i < 8; ++i) {
        const float angle = 0.8f * static_cast<float>(i);
        const vec3 way(std::cos(angle), std::sin(angle), 0.0f);
        const auto area_at = [&](float distance) {
          return sum_up(target, kind, params(), samples, center_at(middle - distance * way), {{}, {0}, {}})[0];
        };
        EXPECT_FLOAT_EQ(area_at(radius - 1.1f * half_diagonal), samples.sample[0].area) << kind << " by " << target.name;
        EXPECT_EQ(area_at(radius + 1.1f * half_diagonal), 0.0f) << kind << " by " << target.name;
        // The rim is curved, so that it leaves a little less than half.
        EXPECT_NEAR(area_at(radius) / samples.sample[0].area, 0.5f, 0.05f) << kind << " by " << target.name;
      }
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
  const Sample sample = sample_of(whole);
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
