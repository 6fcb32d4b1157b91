// Charts that share texture space → a layout in which none do, and nothing else changes.
#include "mesh/layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "bake/shapes.h"
#include "engine/paper/baked.h"
#include "mesh/cut.h"
#include "support/layout.h"
#include "support/percent_ae.h"
#include "support/run.h"

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
  std::vector<vec2> uvs;
  for (int corner = 0; corner < 3 * built.triangles.triangle_count; ++corner) {
    const int32_t chart = built.charts.triangle_chart[at(corner / 3)];
    const double scale = chart == built.charts.chart_count - 1 ? shrink : 1.0;
    uvs.push_back(vec2((built.uv(corner) - box[at(chart)].low) * scale));
  }
  built.triangles.corner_uv = std::move(uvs);
  return build(std::move(built.triangles));
}

Built repacked(Built built) {
  built.charts = repack_charts(built.triangles, built.charts).value();
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

// Half of the distance between two charts lies on either side of each: a buffer of 1024 has a texel and a half there.
TEST(Layout, all_charts_keep_their_distance_from_all_sides_of_the_square) {
  for (const Box &box : boxes(repacked(stacked_torus()))) {
    EXPECT_GE(std::min(box.low.x, box.low.y), 1.49 / 1024);
    EXPECT_LE(std::max(box.high.x, box.high.y), 1 - 1.49 / 1024);
  }
}

// A stack of equal squares fills the square's rows and columns: some chart comes near to each of its sides.
TEST(Layout, charts_that_fill_the_square_keep_their_distance_from_its_high_sides_too) {
  const Built built = repacked(build(grid(8, 8, [](dvec2 position, int x, int y) { return position - dvec2(x, y); })));
  Box all;
  std::vector<Box> box = boxes(built);
  for (const Box &each : box) all = {glm::min(all.low, each.low), glm::max(all.high, each.high)};
  for (const double distance : {all.low.x, all.low.y, 1 - all.high.x, 1 - all.high.y}) EXPECT_GE(distance, 1.49 / 1024);
  for (size_t i = 0; i < box.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const dvec2 gap = glm::max(box[i].low - box[j].high, box[j].low - box[i].high);
      EXPECT_GE(std::max(gap.x, gap.y), 2.99 / 1024) << i << " and " << j;
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

TEST(Layout, wedges_follow_their_corners) {
  const Built before = stacked_torus(), after = repacked(before);
  for (size_t corner = 0; corner < after.charts.corner_uv.size(); ++corner) {
    const int32_t wedge = after.charts.corner_wedge[corner];
    ASSERT_GE(wedge, 0);
    EXPECT_LT(length(after.charts.wedges[at(wedge)].uv - after.charts.corner_uv[corner]), 1e-6f); // moved apart, both rounded
  }
  const double scale = std::sqrt(signed_areas(after)[0] / signed_areas(before)[0]);
  for (size_t i = 0; i < after.charts.wedges.size(); ++i) {
    const Wedge &wedge = after.charts.wedges[i], &old_wedge = before.charts.wedges[i];
    EXPECT_NEAR(length(wedge.inside - wedge.uv), scale * length(old_wedge.inside - old_wedge.uv), 1e-6);
  }
}

TEST(Layout, what_links_charts_stays_what_it_is) {
  const Built before = stacked_torus(), after = repacked(before);
  EXPECT_EQ(before.charts.triangle_chart, after.charts.triangle_chart);
  EXPECT_EQ(before.charts.corner_wedge, after.charts.corner_wedge);
  ASSERT_EQ(before.charts.borders.size(), after.charts.borders.size());
  for (size_t i = 0; i < before.charts.borders.size(); ++i)
    EXPECT_EQ(before.charts.borders[i].twin, after.charts.borders[i].twin);
  Triangles laid_out = after.triangles;
  laid_out.corner_uv = after.charts.corner_uv;
  EXPECT_EQ(build(std::move(laid_out)).charts.chart_count, 24) << "charts found afresh are the same";
}

// ---- Texel densities

// Square roots of each chart's area in the UV map for its area on the surface.
std::vector<double> densities(const Built &built) {
  std::vector<double> uv = signed_areas(built), surface(uv.size(), 0.0);
  for (int t = 0; t < built.triangles.triangle_count; ++t) {
    const dvec3 p(built.position(3 * t)), q(built.position(3 * t + 1)), r(built.position(3 * t + 2));
    if (const int32_t chart = built.charts.triangle_chart[at(t)]; chart >= 0)
      surface[at(chart)] += 0.5 * glm::length(glm::cross(q - p, r - p));
  }
  for (size_t i = 0; i < uv.size(); ++i) uv[i] = std::sqrt(std::abs(uv[i]) / surface[i]);
  return uv;
}

// 24 equal quads in a row, each on a chart of its own that is 1.25 times as large as the one before.
Built growing_charts() {
  return build(
      grid(24, 1, [](dvec2 position, int x, int) { return 0.004 * std::pow(1.25, x) * dvec2(position.x - x, position.y); }));
}

TEST(Layout, texel_densities_come_within_a_factor_of_two_of_the_median) {
  const Built before = growing_charts();
  ASSERT_EQ(before.charts.chart_count, 24);
  std::vector<double> old = densities(before), now = densities(repacked(before));
  std::sort(old.begin(), old.end());
  std::sort(now.begin(), now.end());
  EXPECT_GT(old.back() / old.front(), 100.0);
  EXPECT_NEAR(now.back() / now.front(), 4.0, 0.01) << "half of the median and twice the median; UVs are floats";
  EXPECT_NEAR(now[12] / now[11], old[12] / old[11], 0.01) << "those between keep their proportions";
}

TEST(Layout, a_map_that_fills_the_square_is_left_as_it_is_where_a_gain_is_asked_for) {
  Built built = build(grid(8, 8, [](dvec2 position, int, int) { return position / 8.0; }));
  EXPECT_FALSE(repack_charts(built.triangles, built.charts, 1.5));
  Built small = build(grid(8, 8, [](dvec2 position, int, int) { return position / 80.0; }));
  const std::optional<Charts> larger = repack_charts(small.triangles, small.charts, 1.5);
  ASSERT_TRUE(larger);
  small.charts = *larger;
  EXPECT_GT(boxes(small)[0].high.x - boxes(small)[0].low.x, 0.95);
}

// Found by fuzzing.
TEST(Layout, a_mesh_without_charts_is_left_as_it_is) {
  Triangles triangles;
  Charts charts;
  EXPECT_FALSE(repack_charts(triangles, charts, 1.5, 1));
}

TEST(Layout, tens_of_thousands_of_charts_fit) {
  const Built built = repacked(build(grid(200, 150, [](dvec2 position, int x, int y) { return position - dvec2(x, y); })));
  ASSERT_EQ(built.charts.chart_count, 30000);
  EXPECT_FALSE(cut_charts(built.half_edges, built.charts).overlapping);
}

// ---- Charts that overlap themselves

// The plane of corner_uvs bent around a point for a little more than `turns` turns: the chart lies on itself.
void wrap_around(TestMesh &mesh, double turns) {
  for (size_t i = 0; i < mesh.corner_uvs.size(); i += 2) {
    const double angle = 2 * pi * turns * static_cast<double>(mesh.corner_uvs[i]);
    const double radius = 0.15 + 0.34 * static_cast<double>(mesh.corner_uvs[i + 1]);
    mesh.corner_uvs[i] = static_cast<float>(0.5 + radius * std::cos(angle));
    mesh.corner_uvs[i + 1] = static_cast<float>(0.5 - radius * std::sin(angle));
  }
}

TestMesh wrapped(TestMesh mesh, double turns = 2.3) {
  lay_out(mesh, {.rotate = false, .mirror = false});
  wrap_around(mesh, turns);
  return mesh;
}

Built cut_and_repacked(Built built) {
  const Cuts cuts = cut_charts(built.half_edges, built.charts);
  EXPECT_GT(cuts.cut_charts, 0);
  built.charts = build_charts(built.triangles, built.half_edges, cuts.triangle_piece);
  return repacked(std::move(built));
}

// The linear map that takes a triangle's edges from one layout to another.
dmat2 linear_map(const Built &before, const Built &after, int corner) {
  const auto edges = [&](const Built &built) {
    return dmat2(built.uv(corner + 1) - built.uv(corner), built.uv(corner + 2) - built.uv(corner));
  };
  return edges(after) * glm::inverse(edges(before));
}

TEST(Layout, all_triangles_of_a_piece_of_a_chart_that_lay_on_itself_move_by_one_linear_map) {
  const Built before = build(wrapped(torus(1.0, 0.4, {.vertices = 3000}))), after = cut_and_repacked(before);
  EXPECT_GE(after.charts.chart_count, 3);
  std::vector<int> largest(at(after.charts.chart_count), -1); // the corner of a triangle that rounding does not change
  const auto area = [&](int corner) {
    return std::abs(paradesc::cross(before.uv(corner + 1) - before.uv(corner), before.uv(corner + 2) - before.uv(corner)));
  };
  for (int corner = 0; corner < 3 * after.triangles.triangle_count; corner += 3)
    if (const int32_t chart = after.charts.triangle_chart[at(corner / 3)]; chart >= 0)
      if (int &best = largest[at(chart)]; best < 0 || area(corner) > area(best)) best = corner;
  for (int corner = 0; corner < 3 * after.triangles.triangle_count; ++corner) {
    const int32_t chart = after.charts.triangle_chart[at(corner / 3)];
    if (chart < 0) continue;
    const dmat2 map = linear_map(before, after, largest[at(chart)]);
    const dvec2 old_edge = before.uv(next_corner(corner)) - before.uv(corner);
    EXPECT_GT(glm::determinant(map), 0.0);
    EXPECT_LT(length(after.uv(next_corner(corner)) - after.uv(corner) - map * old_edge), 2e-5) << "UVs are floats";
  }
  EXPECT_FALSE(cut_charts(after.half_edges, after.charts).overlapping);
}

// ---- Charts that the map stretches

// An upright grid whose UV map is squeezed to a hundredth along a direction of its own.
TEST(Layout, a_chart_squeezed_in_one_direction_is_widened_until_its_texels_are_about_square) {
  const dvec2 along(0.8, 0.6), across(-0.6, 0.8);
  const Built built = repacked(build(grid(8, 8, [&](dvec2 position, int, int) {
    return dvec2(0.5) + (0.01 * glm::dot(position, along) * along + glm::dot(position, across) * across) / 16.0;
  })));
  for (int corner = 0; corner < 3 * built.triangles.triangle_count; corner += 3) {
    const dvec2 p(built.position(corner)), q(built.position(corner + 1)), r(built.position(corner + 2));
    const dmat2 map = dmat2(built.uv(corner + 1) - built.uv(corner), built.uv(corner + 2) - built.uv(corner)) *
                      glm::inverse(dmat2(q - p, r - p));
    const double squares = glm::dot(map[0], map[0]) + glm::dot(map[1], map[1]), area = glm::determinant(map);
    const double ratio = (squares + std::sqrt(squares * squares - 4 * area * area)) / (2 * std::abs(area));
    EXPECT_LT(ratio, 1.42) << "widened by a power of two";
  }
  const Box box = boxes(built)[0];
  EXPECT_GT(std::max(box.high.x - box.low.x, box.high.y - box.low.y), 0.95);
}

// Widened to squares it would be 64 times as long as wide, a few texels, and have no more of them along its length.
TEST(Layout, a_ribbon_over_the_whole_square_stays_wide) {
  const Built built = repacked(build(grid(64, 1, [](dvec2 position, int, int) { return position / dvec2(64, 1); })));
  const dvec2 size = boxes(built)[0].high - boxes(built)[0].low;
  EXPECT_GT(std::min(size.x, size.y), 0.24);
}

class PrivateLayout : public OnDevice {};

TEST_F(PrivateLayout, no_texel_has_two_owners) {
  for (const TestMesh &mesh : {wrapped(torus(1.0, 0.4, {.vertices = 3000})), wrapped(sphere(1.0, {.vertices = 3000}), 1.6)}) {
    const Built before = build(mesh);
    EXPECT_GT(bake(*thread, before, 1024).counts.overlapping, 10000);
    EXPECT_EQ(bake(*thread, cut_and_repacked(before), 1024).counts.overlapping, 0);
  }
}

class LaidOutAfresh : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    context = open_context(device_backend(), why_not);
    if (!context) GTEST_SKIP() << why_not;
  }
  Context context;
  std::vector<std::string> names{"mean_curvature", "gaussian_curvature"};
};

// 1 % is asked for; sound maps of these meshes give 0.25 % at most (analytic_test.cpp), but bending the map around a point spends
// texels unevenly.
TEST_F(LaidOutAfresh, curvatures_over_a_map_that_lies_on_itself_are_those_of_the_surface) {
  for (const TestMesh &mesh : {wrapped(torus(1.0, 0.4)), wrapped(sphere(1.0), 1.6)}) {
    const Results results = compute(context.get(), mesh, {}, names);
    EXPECT_EQ(results.report.private_layout, PDESC_LAYOUT_OVERLAPS);
    EXPECT_EQ(results.report.cut_charts, 1);
    EXPECT_EQ(results.report.overlapping_texels, 0);
    EXPECT_EQ(results.report.undefined_vertices, 0);
    EXPECT_GT(results.report.coverage_mean, 0.99);
    const PercentAe h = percent_ae(results["mean_curvature"], mesh.H), k = percent_ae(results["gaussian_curvature"], mesh.K);
    RecordProperty(mesh.domain == Domain::sphere ? "sphere_H" : "torus_H", std::to_string(h.mean));
    EXPECT_LE(h.mean, 1.0);
    EXPECT_LE(k.mean, 1.0);
  }
}

TEST_F(LaidOutAfresh, a_map_in_a_corner_of_the_square_is_laid_out_to_fill_it) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 5000});
  lay_out(mesh, {.charts = 6});
  const Results original = compute(context.get(), mesh, {}, names);
  EXPECT_EQ(original.report.private_layout, PDESC_LAYOUT_GIVEN);
  for (float &uv : mesh.corner_uvs) uv *= 0.1f;
  const Results results = compute(context.get(), mesh, {}, names);
  EXPECT_EQ(results.report.private_layout, PDESC_LAYOUT_SPARSE);
  EXPECT_EQ(results.report.cut_charts, 0);
  EXPECT_GT(results.report.radius_in_texels, 0.8 * original.report.radius_in_texels);
  EXPECT_LE(percent_ae(results["mean_curvature"], mesh.H).mean, 1.0); // 5000 vertices
}

// Corner UVs times a factor along each axis.
void scale_map(TestMesh &mesh, float u, float v) {
  for (size_t i = 0; i < mesh.corner_uvs.size(); i += 2) {
    mesh.corner_uvs[i] *= u;
    mesh.corner_uvs[i + 1] *= v;
  }
}

TEST_F(LaidOutAfresh, a_map_squeezed_in_one_direction_gives_the_values_of_the_map_before) {
  for (const int charts : {1, 6})
    for (const int32_t evaluate : {PDESC_EVALUATE_VERTEX, PDESC_EVALUATE_TEXEL}) {
      TestMesh mesh = torus(1.0, 0.4, {.vertices = 5000});
      lay_out(mesh, {.charts = charts});
      const Settings settings{.evaluate = evaluate};
      const Results original = compute(context.get(), mesh, settings, names);
      scale_map(mesh, 0.01f, 1.0f);
      const Results results = compute(context.get(), mesh, settings, names);
      EXPECT_EQ(results.report.private_layout, PDESC_LAYOUT_SPARSE);
      EXPECT_GT(results.report.radius_in_texels, 0.7 * original.report.radius_in_texels);
      EXPECT_EQ(results.report.bare_triangles, 0);
      // Other texels, of about the same size: values differ by a fifth of what they are off at most.
      for (const auto &[name, exact] : {std::pair("mean_curvature", &mesh.H), {"gaussian_curvature", &mesh.K}}) {
        const PercentAe before = percent_ae(original[name], *exact), now = percent_ae(results[name], *exact);
        EXPECT_LE(now.mean, 1.2 * before.mean) << name;
        EXPECT_LE(now.max, 1.2 * before.max) << name;
      }
    }
}

TEST_F(LaidOutAfresh, charts_that_are_squeezed_and_share_texture_space_are_widened_as_well) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 5000});
  lay_out(mesh, {.charts = 6});
  const PercentAe before = percent_ae(compute(context.get(), mesh, {}, names)["mean_curvature"], mesh.H);
  for (size_t i = 0; i < mesh.corner_uvs.size(); ++i) mesh.corner_uvs[i] -= mesh.corner_uvs[i] < 0.5f ? 0.0f : 0.5f; // stacked
  scale_map(mesh, 0.01f, 1.0f);
  const Results results = compute(context.get(), mesh, {}, names);
  EXPECT_EQ(results.report.private_layout, PDESC_LAYOUT_OVERLAPS);
  EXPECT_LE(percent_ae(results["mean_curvature"], mesh.H).mean, 1.2 * before.mean);
}

// A radius has two texels around the ring, and a hundred around the tube: no layout of the same buffers has more around the ring.
TEST_F(LaidOutAfresh, a_radius_of_few_texels_in_one_direction_is_said_where_no_layout_has_more) {
  TestMesh mesh = torus(1.0, 0.02, {.vertices = 5000});
  lay_out(mesh, {.rotate = false, .mirror = false});
  scale_map(mesh, 1.0f, 50.0f); // over the whole square
  const Mesh created = make_mesh(context.get(), mesh);
  const pdesc_options options = options_of({.buffer_size = 256});
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  ASSERT_EQ(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
  const Field owner(field);
  EXPECT_NE(std::string(pdesc_field_warnings(field)).find("The radius spans only 2."), std::string::npos)
      << pdesc_field_warnings(field);
}

TEST_F(LaidOutAfresh, the_mesh_report_goes_on_describing_the_map_as_given) {
  const TestMesh mesh = wrapped(torus(1.0, 0.4, {.vertices = 3000}));
  const Mesh created = make_mesh(context.get(), mesh);
  pdesc_mesh_report before, after;
  pdesc_mesh_report_init(&before);
  pdesc_mesh_report_init(&after);
  ASSERT_EQ(pdesc_mesh_get_report(created.get(), &before), PDESC_OK);
  const pdesc_options options = options_of({});
  std::vector<float> first, values(at(mesh.vertex_count));
  for (int frame = 0; frame < 2; ++frame) {
    const char *name = "mean_curvature";
    pdesc_field *field = nullptr;
    ASSERT_EQ(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
    const Field owner(field);
    ASSERT_EQ(pdesc_field_values(field, name, values.data(), mesh.vertex_count), PDESC_OK);
    if (frame == 0) first = values;
    EXPECT_NE(std::string(pdesc_field_warnings(field)).find("1 of them with themselves"), std::string::npos);
  }
  expect_same_bits(first, values);
  ASSERT_EQ(pdesc_mesh_get_report(created.get(), &after), PDESC_OK);
  EXPECT_EQ(after.charts, before.charts);
  EXPECT_EQ(after.seam_edges, before.seam_edges);
}

} // namespace
} // namespace paradesc::test
