// The centers of a map over the layout, and values looked up there, on planes where everything is linear.
#include "sample/texels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "bake/shapes.h"

namespace paradesc::test {
namespace {

constexpr int size = 64;

dvec2 center_of(int32_t texel) { return dvec2(texel % size + 0.5, texel / size + 0.5) / static_cast<double>(size); }

dvec2 uv_of(const Built &built, const TexelCenter &center) {
  const vec3 weights(1.0f - center.weights.x - center.weights.y, center.weights);
  dvec2 uv(0.0);
  for (int i = 0; i < 3; ++i) uv += built.uv(3 * center.triangle + i) * static_cast<double>(weights[i]);
  return uv;
}

// Values at each center: a linear function of the position on the surface, and the number of the chart.
CenterResults linear_results(const Built &built, const TexelMap &map) {
  CenterResults results;
  results.values.resize(2);
  for (const TexelCenter &center : map.centers) {
    const int32_t chart = built.charts.triangle_chart[at(center.triangle)];
    const dvec2 on_plane =
        inverse(chart_of_quad(chart % 4, chart / 4).linear) * (uv_of(built, center) - chart_of_quad(chart % 4, chart / 4).origin);
    results.values[0].push_back(static_cast<float>(2.0 * on_plane.x - 3.0 * on_plane.y));
    results.values[1].push_back(static_cast<float>(chart));
  }
  results.coverage.assign(map.centers.size(), 1.0f);
  results.boundary.assign(map.centers.size(), 0);
  return results;
}

TEST(TexelMap, has_every_texel_whose_center_lies_on_a_triangle_there) {
  const Built built = plane_of_twelve_charts();
  const TexelMap map = build_texel_map(built.charts, size);
  int on_centers = 0;
  for (const TexelCenter &center : map.centers) {
    const double gap = length(uv_of(built, center) - center_of(center.texel)) * size;
    EXPECT_LE(gap, 0.7073) << "a border through the texel is at most half a diagonal from its center";
    on_centers += gap < 1e-3;
    EXPECT_EQ(map.index[at(center.texel)], static_cast<int32_t>(&center - map.centers.data()));
  }
  int inside = 0;
  for (int32_t texel = 0; texel < size * size; ++texel) {
    bool covered = false;
    for (int32_t t = 0; t < built.triangles.triangle_count; ++t) {
      const dvec2 p = center_of(texel), a = built.uv(3 * t), b = built.uv(3 * t + 1), c = built.uv(3 * t + 2);
      const double turn = paradesc::cross(b - a, c - a) > 0.0 ? 1.0 : -1.0;
      covered |= turn * paradesc::cross(b - a, p - a) > 0.0 && turn * paradesc::cross(c - b, p - b) > 0.0 &&
                 turn * paradesc::cross(a - c, p - c) > 0.0;
    }
    inside += covered;
    EXPECT_TRUE(!covered || map.index[at(texel)] >= 0) << "texel " << texel;
  }
  EXPECT_GT(inside, 200);
  EXPECT_GE(on_centers, inside);
  EXPECT_LE(on_centers, inside + 10) << "centers on an edge";
}

TEST(TexelMap, has_every_texel_that_a_chart_edge_passes_through) {
  const Built built = plane_of_twelve_charts();
  const TexelMap map = build_texel_map(built.charts, size);
  for (const Border &border : built.charts.borders) {
    const dvec2 a = built.uv(border.half_edge), b = built.uv(next_corner(border.half_edge));
    for (int k = 0; k <= 200; ++k) {
      const dvec2 position = (a + (b - a) * (k / 200.0)) * static_cast<double>(size);
      EXPECT_GE(map.index[at(static_cast<int>(position.y) * size + static_cast<int>(position.x))], 0);
    }
  }
}

TEST(TexelMap, a_chart_smaller_than_a_texel_has_one) {
  const Built built = build(grid(2, 1, [](dvec2 position, int x, int) {
    return x == 0 ? position * 0.4 + 0.05 : dvec2(0.8) + (position - dvec2(1, 0)) * 1e-4;
  }));
  const TexelMap map = build_texel_map(built.charts, size);
  EXPECT_TRUE(
      std::any_of(map.centers.begin(), map.centers.end(), [](const TexelCenter &center) { return center.triangle >= 2; }));
}

TEST(TexelLookup, is_exact_for_what_is_linear_and_stays_on_the_chart_of_each_center) {
  const Built built = plane_of_twelve_charts();
  const TexelMap map = build_texel_map(built.charts, size);
  const CenterResults found = look_up(map, linear_results(built, map), built.charts);
  ASSERT_EQ(found.coverage.size(), at(built.half_edges.point_count));
  for (size_t i = 0; i < found.coverage.size(); ++i) {
    const Wedge &wedge = built.charts.wedges[at(built.charts.point_wedge[i])];
    EXPECT_FLOAT_EQ(found.values[1][i], static_cast<float>(wedge.chart)) << "of its own chart";
    // All are corners of charts, beyond most of their texels: a plane is fitted. UVs are floats; a texel is 1/5 of a quad.
    const vec3 p = built.triangles.positions[at(built.half_edges.point_vertex[i])];
    EXPECT_NEAR(found.values[0][i], 2.0f * p.x - 3.0f * p.y, 1e-3f);
  }
}

TEST(TexelLookup, within_a_chart_a_linear_function_is_exact) {
  const Built built = build(grid(6, 6, [](dvec2 position, int, int) { return (position + 1.1) / 8.3; }));
  const TexelMap map = build_texel_map(built.charts, size);
  CenterResults all;
  all.values.resize(1);
  for (const TexelCenter &center : map.centers) all.values[0].push_back(static_cast<float>(uv_of(built, center).x));
  all.coverage.assign(map.centers.size(), 1.0f);
  all.boundary.assign(map.centers.size(), 0);
  const CenterResults found = look_up(map, all, built.charts);
  int inner = 0;
  for (size_t i = 0; i < found.coverage.size(); ++i) {
    const vec3 p = built.triangles.positions[at(built.half_edges.point_vertex[i])];
    if (p.x < 0.5f || p.y < 0.5f || p.x > 5.5f || p.y > 5.5f) continue;
    EXPECT_NEAR(found.values[0][i], (p.x + 1.1f) / 8.3f, 1e-6f) << "a few roundings";
    ++inner;
  }
  EXPECT_EQ(inner, 25);
}

TEST(TexelLookup, undefined_texels_are_left_out_and_directions_do_not_cancel) {
  const Built built = build(grid(1, 1, [](dvec2 position, int, int) { return position * 0.5 + 0.25; }));
  const TexelMap map = build_texel_map(built.charts, size);
  CenterResults all;
  all.values.resize(2);
  for (size_t i = 0; i < map.centers.size(); ++i) {
    const bool odd = (map.centers[i].texel % size + map.centers[i].texel / size) % 2 != 0;
    all.values[0].push_back(odd ? std::numeric_limits<float>::quiet_NaN() : 7.0f);
    for (const float part : {0.6f, 0.8f, 0.0f}) all.values[1].push_back(odd ? -part : part);
  }
  all.coverage.assign(map.centers.size(), 1.0f);
  all.boundary.assign(map.centers.size(), 0);
  const CenterResults found = look_up(map, all, built.charts);
  ASSERT_EQ(found.coverage.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(found.values[0][i], 7.0f);
    EXPECT_NEAR(std::abs(found.values[1][3 * i]), 0.6f, 1e-6f);
    EXPECT_NEAR(std::abs(found.values[1][3 * i + 1]), 0.8f, 1e-6f);
  }
}

// Directions a tenth of a radian to either side, each other one with the other sign: what were added up would lie across.
TEST(TexelLookup, directions_of_either_sign_have_their_mean) {
  const Built built = build(grid(1, 1, [](dvec2 position, int, int) { return position * 0.5 + 0.25; }));
  const TexelMap map = build_texel_map(built.charts, size);
  CenterResults all;
  all.values.resize(1);
  for (const TexelCenter &center : map.centers) {
    const float sign = (center.texel % size + center.texel / size) % 2 != 0 ? -1.0f : 1.0f;
    for (const float part : {sign * std::cos(0.1f), std::sin(0.1f), 0.0f}) all.values[0].push_back(part);
  }
  all.coverage.assign(map.centers.size(), 1.0f);
  all.boundary.assign(map.centers.size(), 0);
  const CenterResults found = look_up(map, all, built.charts);
  ASSERT_EQ(found.coverage.size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_GT(std::abs(found.values[0][3 * i]), 0.97f) << i;
}

// Values are the numbers of the centers.
CenterResults numbered_results(const TexelMap &map) {
  CenterResults results;
  results.values.resize(1);
  for (size_t i = 0; i < map.centers.size(); ++i) results.values[0].push_back(static_cast<float>(i));
  results.coverage.assign(map.centers.size(), 1.0f);
  results.boundary.assign(map.centers.size(), 0);
  return results;
}

TEST(TexelLookup, takes_the_nearest_texel_where_none_lies_beside_the_wedge) {
  const Built built = build(grid(1, 1, [](dvec2 position, int, int) { return position * 0.5 + 0.25; }));
  TexelMap map = build_texel_map(built.charts, size);
  const CenterResults all = numbered_results(map);
  const auto gap_of = [&](const TexelCenter &center, const Wedge &wedge) {
    return length(center_of(center.texel) - dvec2(wedge.uv)) * static_cast<double>(size);
  };
  for (const Wedge &wedge : built.charts.wedges)
    for (const TexelCenter &center : map.centers)
      if (gap_of(center, wedge) < 3.5) map.index[at(center.texel)] = -1;
  const CenterResults found = look_up(map, all, built.charts);
  ASSERT_EQ(found.coverage.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    const Wedge &wedge = built.charts.wedges[at(built.charts.point_wedge[i])];
    double nearest = 1e30;
    for (const TexelCenter &center : map.centers)
      if (map.index[at(center.texel)] >= 0) nearest = std::min(nearest, gap_of(center, wedge));
    EXPECT_NEAR(gap_of(map.centers[at(static_cast<int>(found.values[0][i]))], wedge), nearest, 1e-4) << i;
  }
}

TEST(TexelLookup, points_without_a_texel_of_their_chart_are_undefined) {
  const Built built = plane_of_twelve_charts();
  const TexelMap map = build_texel_map(built.charts, 1);
  ASSERT_EQ(map.centers.size(), 1u) << "all charts share one texel";
  CenterResults all = numbered_results(map);
  all.values = {{5.0f}, {0.6f, 0.8f, 0.0f}};
  const CenterResults found = look_up(map, all, built.charts);
  ASSERT_EQ(found.values[1].size(), 3 * found.coverage.size());
  int defined = 0;
  for (size_t i = 0; i < found.coverage.size(); ++i) {
    const bool there = built.charts.wedges[at(built.charts.point_wedge[i])].chart == map.centers[0].chart;
    defined += there;
    EXPECT_EQ(std::isnan(found.coverage[i]), !there);
    EXPECT_EQ(std::isnan(found.values[0][i]), !there);
    for (size_t k = 0; k < 3; ++k) {
      const float value = found.values[1][3 * i + k];
      EXPECT_TRUE(there ? std::abs(value - all.values[1][k]) <= 1e-6f : std::isnan(value)) << value;
    }
    if (!there) continue;
    EXPECT_EQ(found.values[0][i], 5.0f);
    EXPECT_EQ(found.coverage[i], 1.0f);
  }
  EXPECT_GT(defined, 0);
}

} // namespace
} // namespace paradesc::test
