// Charts that share texture space → a layout in which none do, and nothing else changes.
#include "mesh/layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "bake/shapes.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

struct Box {
  dvec2 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
};

std::vector<Box> boxes(const Built &built) {
  std::vector<Box> result(at(built.charts.chart_count));
  for (int corner = 0; corner < 3 * built.triangles.triangle_count; ++corner) {
    const int32_t chart = built.charts.triangle_chart[at(corner / 3)];
    if (chart < 0) continue;
    result[at(chart)].low = glm::min(result[at(chart)].low, built.uv(corner));
    result[at(chart)].high = glm::max(result[at(chart)].high, built.uv(corner));
  }
  return result;
}

std::vector<double> signed_areas(const Built &built) {
  std::vector<double> areas(at(built.charts.chart_count), 0.0);
  for (int t = 0; t < built.triangles.triangle_count; ++t)
    if (const int32_t chart = built.charts.triangle_chart[at(t)]; chart >= 0)
      areas[at(chart)] += 0.5 * paradesc::cross(built.uv(3 * t + 1) - built.uv(3 * t), built.uv(3 * t + 2) - built.uv(3 * t));
  return areas;
}

// A torus whose 24 charts all have their box' low corner at the origin; the last one is shrunk by `shrink`.
Built stacked_torus(double shrink = 1.0) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 1500});
  lay_out(mesh, {.charts = 24});
  Built built = build(mesh);
  const std::vector<Box> box = boxes(built);
  for (int corner = 0; corner < 3 * built.triangles.triangle_count; ++corner) {
    const int32_t chart = built.charts.triangle_chart[at(corner / 3)];
    const double scale = chart == built.charts.chart_count - 1 ? shrink : 1.0;
    built.triangles.corner_uv[at(corner)] = vec2((built.uv(corner) - box[at(chart)].low) * scale);
  }
  return build(std::move(built.triangles));
}

Built repacked(Built built) {
  repack_charts(built.triangles, built.charts);
  return built;
}

TEST(Layout, no_two_charts_boxes_overlap_and_all_lie_in_the_unit_square) {
  const Built built = repacked(stacked_torus());
  const std::vector<Box> box = boxes(built);
  ASSERT_EQ(box.size(), 24u);
  for (size_t i = 0; i < box.size(); ++i) {
    EXPECT_GE(std::min(box[i].low.x, box[i].low.y), 0.0);
    EXPECT_LE(std::max(box[i].high.x, box[i].high.y), 1.0);
    for (size_t j = 0; j < i; ++j) {
      const dvec2 gap = glm::max(box[i].low - box[j].high, box[j].low - box[i].high);
      EXPECT_GE(std::max(gap.x, gap.y), 2.0 / 1024) << i << " and " << j << ": two texels at least of a 1024 buffer";
    }
  }
}

TEST(Layout, all_charts_are_scaled_alike_and_none_is_turned_over) {
  const Built before = stacked_torus(), after = repacked(before);
  const std::vector<double> old_areas = signed_areas(before), areas = signed_areas(after);
  for (size_t i = 0; i < areas.size(); ++i)
    EXPECT_NEAR(areas[i] / old_areas[i], areas[0] / old_areas[0], 1e-4 * areas[0] / old_areas[0]) << i << ": UVs are floats";
  EXPECT_GT(areas[0] / old_areas[0], 0.0);
}

TEST(Layout, every_triangle_keeps_its_shape) {
  const Built before = stacked_torus(), after = repacked(before);
  const double scale = std::sqrt(signed_areas(after)[0] / signed_areas(before)[0]);
  for (int corner = 0; corner < 3 * before.triangles.triangle_count; ++corner) {
    const double old_edge = length(before.uv(next_corner(corner)) - before.uv(corner));
    EXPECT_NEAR(length(after.uv(next_corner(corner)) - after.uv(corner)), scale * old_edge, 1e-6); // roundings of UVs below 1
  }
}

TEST(Layout, most_of_the_square_is_used) {
  double sum = 0.0;
  for (const Box &box : boxes(repacked(stacked_torus()))) sum += (box.high.x - box.low.x) * (box.high.y - box.low.y);
  EXPECT_GT(sum, 0.5);
}

TEST(Layout, a_tiny_chart_grows_so_that_it_does_not_fall_between_texels) {
  const Built built = repacked(stacked_torus(1e-3));
  const Box box = boxes(built).back();
  EXPECT_GE(std::max(box.high.x - box.low.x, box.high.y - box.low.y), 3.0 / 1024) << "three texels of a 1024 buffer";
  const std::vector<double> areas = signed_areas(built), old_areas = signed_areas(stacked_torus(1e-3));
  for (size_t i = 0; i + 1 < areas.size(); ++i)
    EXPECT_NEAR(areas[i] / old_areas[i], areas[0] / old_areas[0], 1e-4 * areas[0] / old_areas[0]) << "the others are still alike";
}

TEST(Layout, sites_follow_their_corners) {
  const Built before = stacked_torus(), after = repacked(before);
  for (size_t corner = 0; corner < after.triangles.corner_uv.size(); ++corner) {
    const int32_t site = after.charts.corner_site[corner];
    ASSERT_GE(site, 0);
    EXPECT_LT(length(after.charts.sites[at(site)].uv - after.triangles.corner_uv[corner]), 1e-6f); // moved apart, both rounded
  }
  const double scale = std::sqrt(signed_areas(after)[0] / signed_areas(before)[0]);
  for (size_t i = 0; i < after.charts.sites.size(); ++i) {
    const Site &site = after.charts.sites[i], &old_site = before.charts.sites[i];
    EXPECT_NEAR(length(site.inside - site.uv), scale * length(old_site.inside - old_site.uv), 1e-6);
  }
}

TEST(Layout, what_links_charts_stays_what_it_is) {
  const Built before = stacked_torus(), after = repacked(before);
  EXPECT_EQ(before.charts.triangle_chart, after.charts.triangle_chart);
  EXPECT_EQ(before.charts.corner_site, after.charts.corner_site);
  ASSERT_EQ(before.charts.borders.size(), after.charts.borders.size());
  for (size_t i = 0; i < before.charts.borders.size(); ++i)
    EXPECT_EQ(before.charts.borders[i].twin, after.charts.borders[i].twin);
  EXPECT_EQ(build(after.triangles).charts.chart_count, 24) << "charts found afresh are the same";
}

} // namespace
} // namespace paradesc::test
