// The border grid against brute force: what is in a texel, and how far the next border is.
#include "engine/paper/border_grid.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "bake/shapes.h"

namespace paradesc::test {
namespace {

constexpr int size = 64; // texels along a side: a dozen for each chart

std::set<int32_t> borders_in(const BorderGrid &grid, int x, int y) {
  const auto texel = 2 * at(y * size + x);
  std::set<int32_t> borders;
  for (int32_t i = 0; i < -std::min(grid.cells[texel], 0); ++i) borders.insert(grid.list[2 * at(grid.cells[texel + 1] + i)]);
  return borders;
}

// Calls visit(border, position in texels) along every border, ten times a texel.
template <class Visit> void each_border_position(const BorderGrid &grid, const Visit &visit) {
  for (size_t i = 0; i < grid.border_uv.size(); ++i) {
    const dvec4 uv = dvec4(grid.border_uv[i]) * static_cast<double>(size);
    const dvec2 a(uv.x, uv.y), b(uv.z, uv.w);
    const int steps = 1 + static_cast<int>(10 * length(b - a));
    for (int k = 0; k <= steps; ++k) visit(static_cast<int32_t>(i), a + (b - a) * (static_cast<double>(k) / steps));
  }
}

TEST(BorderGrid, a_texel_lists_every_border_that_passes_through_it) {
  const Built built = plane_of_twelve_charts();
  const BorderGrid grid = build_border_grid(built.charts, size);
  ASSERT_EQ(grid.border_uv.size(), 48u);
  each_border_position(grid, [&](int32_t border, dvec2 position) {
    EXPECT_TRUE(borders_in(grid, static_cast<int>(position.x), static_cast<int>(position.y)).contains(border)) << border;
  });
}

TEST(BorderGrid, a_border_is_listed_only_where_it_passes) {
  const Built built = plane_of_twelve_charts();
  const BorderGrid grid = build_border_grid(built.charts, size);
  std::set<std::pair<int32_t, std::pair<int, int>>> near;
  each_border_position(grid, [&](int32_t border, dvec2 position) {
    // Ten positions a texel, and the grid's own margin of a hundredth: a border cuts a corner by 0.15 at most unseen.
    for (const double dx : {-0.15, 0.0, 0.15})
      for (const double dy : {-0.15, 0.0, 0.15})
        near.insert({border, {static_cast<int>(std::floor(position.x + dx)), static_cast<int>(std::floor(position.y + dy))}});
  });
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      for (const int32_t border : borders_in(grid, x, y))
        EXPECT_TRUE(near.contains({border, {x, y}})) << border << ": " << x << ", " << y;
}

TEST(BorderGrid, texels_said_to_be_free_are_free) {
  const Built built = plane_of_twelve_charts();
  const BorderGrid grid = build_border_grid(built.charts, size);
  std::vector<double> nearest(static_cast<size_t>(size) * size, 1e9); // from anywhere in the texel to any border
  each_border_position(grid, [&](int32_t, dvec2 position) {
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const double dx = std::max({x - position.x, position.x - x - 1, 0.0}),
                     dy = std::max({y - position.y, position.y - y - 1, 0.0});
        nearest[at(y * size + x)] = std::min(nearest[at(y * size + x)], std::hypot(dx, dy));
      }
  });
  int free_texels = 0;
  for (size_t i = 0; i < nearest.size(); ++i) {
    const int32_t skip = grid.cells[2 * i];
    if (skip < 0) continue;
    EXPECT_LE(skip, nearest[i]) << "texel " << i;
    // The bound is worth something: it may lose a diagonal for each of the two texels, and what floor() takes.
    EXPECT_GE(skip, nearest[i] - 4.0) << "texel " << i;
    free_texels += skip > 0;
  }
  EXPECT_GT(free_texels, 0);
}

TEST(BorderGrid, the_chart_lies_on_the_left_of_each_of_its_borders) {
  const Built built = plane_of_twelve_charts();
  const BorderGrid grid = build_border_grid(built.charts, size);
  for (size_t i = 0; i < grid.border_uv.size(); ++i) {
    const Border &border = built.charts.borders[i];
    const dvec4 uv(grid.border_uv[i]);
    const dvec2 a(uv.x, uv.y), b(uv.z, uv.w);
    EXPECT_GT(paradesc::cross(b - a, built.uv(previous_corner(border.half_edge)) - a), 0.0) << i;
  }
  for (size_t i = 0; i < grid.list.size(); i += 2) EXPECT_EQ(grid.list[i + 1], built.charts.borders[at(grid.list[i])].chart);
}

TEST(BorderGrid, without_borders_everything_is_free) {
  const BorderGrid grid = build_border_grid({}, 16);
  EXPECT_EQ(grid.cells.size(), 512u);
  for (size_t i = 0; i < grid.cells.size(); i += 2) EXPECT_GE(grid.cells[i], 16);
}

// Two charts of 3 by 2 quads each, side by side: three edges between them.
TEST(Seams, edges_that_follow_one_another_on_both_sides_are_one_seam) {
  const Built built =
      build(grid(6, 3, [](dvec2 position, int x, int) { return position * 0.1 + dvec2(x < 3 ? 0.05 : 0.25, 0.05); }));
  const std::vector<int32_t> seams = number_seams(built.charts);
  std::set<int32_t> numbers;
  int edges = 0;
  for (size_t i = 0; i < seams.size(); ++i) {
    EXPECT_EQ(seams[i] >= 0, built.charts.borders[i].kind == BorderKind::seam);
    if (seams[i] < 0) continue;
    ++edges;
    numbers.insert(seams[i]);
  }
  EXPECT_EQ(edges, 6);
  EXPECT_EQ(numbers.size(), 2u) << "one for each side";
}

TEST(Seams, pieces_that_are_apart_are_several_seams) {
  // The middle one of the three edges goes to a chart of its own.
  const Built built = build(grid(6, 3, [](dvec2 position, int x, int y) {
    return position * 0.1 + dvec2(x < 3 ? 0.05 : x == 3 && y == 1 ? 0.15 : 0.3, 0.05);
  }));
  ASSERT_EQ(built.charts.chart_count, 3);
  const std::vector<int32_t> seams = number_seams(built.charts);
  std::set<int32_t> between;
  for (size_t i = 0; i < seams.size(); ++i)
    if (seams[i] >= 0 && built.charts.borders[i].chart == built.charts.triangle_chart[0]) between.insert(seams[i]);
  EXPECT_EQ(between.size(), 3u) << "above, at and below the middle";
}

} // namespace
} // namespace paradesc::test
