// Charts, wedges, seams and their twins on meshes small enough to count by hand.
#include "mesh/charts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

namespace paradesc {
namespace {

size_t at(int32_t index) { return static_cast<size_t>(index); }

struct Shape {
  std::vector<vec3> positions;
  std::vector<int32_t> faces; // three vertices each
  std::vector<vec2> uvs;      // one for each of those
};

struct Built {
  Triangles triangles;
  HalfEdges half_edges;
  Charts charts;
};

// Expects what holds for every mesh: links of corners, wedges, borders and twins agree.
void expect_sound(const Built &built) {
  const auto &[triangles, half_edges, charts] = built;
  for (int h = 0; h < 3 * triangles.triangle_count; ++h) {
    const int32_t chart = charts.triangle_chart[at(h / 3)];
    ASSERT_LT(chart, charts.chart_count);
    ASSERT_EQ(charts.corner_wedge[at(h)] >= 0, chart >= 0);
    if (chart < 0) {
      EXPECT_EQ(charts.half_edge_border[at(h)], -1);
      continue;
    }
    const Wedge &wedge = charts.wedges[at(charts.corner_wedge[at(h)])];
    EXPECT_EQ(wedge.point, half_edges.corner_point[at(h)]);
    EXPECT_EQ(wedge.chart, chart);
    EXPECT_LT(glm::length(wedge.uv - triangles.corner_uv[at(h)]), 1e-5f);
    const int32_t border = charts.half_edge_border[at(h)];
    if (border < 0) {
      EXPECT_EQ(charts.triangle_chart[at(half_edges.twin[at(h)] / 3)], chart) << "half-edge " << h;
    } else {
      EXPECT_EQ(charts.borders[at(border)].half_edge, h);
    }
  }
  for (size_t i = 0; i < charts.borders.size(); ++i) {
    const Border &border = charts.borders[i];
    const int32_t twin = half_edges.twin[at(border.half_edge)];
    EXPECT_EQ(border.chart, charts.triangle_chart[at(border.half_edge / 3)]);
    EXPECT_EQ(border.kind == BorderKind::boundary, twin < 0);
    EXPECT_EQ(border.kind == BorderKind::seam, border.twin >= 0);
    if (border.kind != BorderKind::seam) continue;
    EXPECT_EQ(charts.borders[at(border.twin)].half_edge, twin);
    EXPECT_EQ(charts.borders[at(border.twin)].twin, static_cast<int32_t>(i));
  }
  for (int32_t point = 0; point < half_edges.point_count; ++point) {
    const int32_t chosen = charts.point_wedge[at(point)];
    for (size_t i = 0; i < charts.wedges.size(); ++i)
      if (charts.wedges[i].point == point) {
        ASSERT_GE(chosen, 0);
        EXPECT_LE(charts.wedges[i].angle, charts.wedges[at(chosen)].angle);
      }
  }
}

Built build(const Shape &shape) {
  Built built;
  built.triangles.vertex_count = static_cast<int>(shape.positions.size());
  built.triangles.triangle_count = static_cast<int>(shape.faces.size() / 3);
  built.triangles.positions = shape.positions;
  built.triangles.corner_vertex = shape.faces;
  built.triangles.corner_uv = shape.uvs;
  built.triangles.half_edge_sharp.assign(shape.faces.size(), 0);
  built.half_edges = build_half_edges(built.triangles);
  built.charts = build_charts(built.triangles, built.half_edges);
  expect_sound(built);
  return built;
}

int count(const Charts &charts, BorderKind kind) {
  return static_cast<int>(std::ranges::count_if(charts.borders, [&](const Border &border) { return border.kind == kind; }));
}

// A flat grid over the unit square of the plane, its UVs the same square.
Shape grid(int width, int height) {
  Shape shape;
  for (int y = 0; y <= height; ++y)
    for (int x = 0; x <= width; ++x) shape.positions.push_back(vec3(x, y, 0) / vec3(width, height, 1));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int32_t a = y * (width + 1) + x, b = a + 1, c = b + width + 1, d = a + width + 1;
      shape.faces.insert(shape.faces.end(), {a, b, c, a, c, d});
    }
  for (int32_t vertex : shape.faces) shape.uvs.push_back(vec2(shape.positions[at(vertex)]));
  return shape;
}

// Each side of the unit cube on a square of its own, 3 by 2 of them with gaps between.
Shape cube_of_six_charts() {
  Shape shape;
  for (int i = 0; i < 8; ++i) shape.positions.push_back(vec3(i & 1, i >> 1 & 1, i >> 2));
  const int32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  const vec2 square[4] = {{0, 0}, {0.25f, 0}, {0.25f, 0.25f}, {0, 0.25f}};
  for (int side = 0; side < 6; ++side)
    for (const int i : {0, 1, 2, 0, 2, 3}) {
      shape.faces.push_back(quads[side][i]);
      shape.uvs.push_back(square[i] + vec2(0.3f * static_cast<float>(side % 3), 0.3f * static_cast<float>(side / 3)));
    }
  return shape;
}

// An open cylinder unrolled onto the unit square: u runs once around, so the last column meets the first.
Shape cylinder(int around, int rings) {
  Shape shape;
  const auto vertex = [&](int i, int j) { return j * around + i % around; };
  const auto uv = [&](int i, int j) { return vec2(i, j) / vec2(around, rings); };
  for (int j = 0; j <= rings; ++j)
    for (int i = 0; i < around; ++i)
      shape.positions.push_back(vec3(std::cos(2 * pi * i / around), std::sin(2 * pi * i / around), j));
  for (int j = 0; j < rings; ++j)
    for (int i = 0; i < around; ++i)
      for (const auto &[x, y] : {std::pair(i, j), {i + 1, j}, {i + 1, j + 1}, {i, j}, {i + 1, j + 1}, {i, j + 1}}) {
        shape.faces.push_back(vertex(x, y));
        shape.uvs.push_back(uv(x, y));
      }
  return shape;
}

TEST(Charts, a_grid_is_one_chart_with_a_boundary_and_no_seam) {
  const Built built = build(grid(3, 2));
  EXPECT_EQ(built.charts.chart_count, 1);
  EXPECT_EQ(built.charts.seam_edges, 0);
  EXPECT_EQ(built.charts.flipped_triangles, 0);
  EXPECT_EQ(built.charts.zero_uv_area_triangles, 0);
  EXPECT_EQ(built.charts.borders.size(), 10u);
  EXPECT_EQ(count(built.charts, BorderKind::boundary), 10);
  EXPECT_EQ(built.charts.wedges.size(), 12u);
}

TEST(Charts, wedges_of_a_point_within_a_flat_surface_share_its_full_turn) {
  Shape shape = grid(2, 2); // the last quad apart
  for (size_t corner = 18; corner < 24; ++corner) shape.uvs[corner] = shape.uvs[corner] * 0.5f - vec2(0.25f);
  const Built built = build(shape);
  std::map<int32_t, double> turn;
  for (const Wedge &wedge : built.charts.wedges) turn[wedge.point] += wedge.angle;
  EXPECT_NEAR(turn[built.half_edges.vertex_point[4]], 2 * pi, 1e-6); // positions are floats
  EXPECT_NEAR(turn[built.half_edges.vertex_point[7]], pi, 1e-6);
  EXPECT_NEAR(turn[built.half_edges.vertex_point[0]], 0.5 * pi, 1e-6);
  EXPECT_EQ(built.charts.wedges[at(built.charts.point_wedge[at(built.half_edges.vertex_point[0])])].uv, shape.uvs[0]);
}

TEST(Charts, inside_lies_in_the_triangle_that_is_widest_at_the_wedge) {
  const Built built = build(grid(3, 2));
  for (const Wedge &wedge : built.charts.wedges) {
    double widest = 0;
    vec2 expected(0);
    for (int corner = 0; corner < 3 * built.triangles.triangle_count; ++corner) {
      if (built.half_edges.corner_point[at(corner)] != wedge.point) continue;
      const auto &uv = built.triangles.corner_uv;
      const vec2 a = uv[at(next_corner(corner))] - uv[at(corner)], b = uv[at(previous_corner(corner))] - uv[at(corner)];
      const double angle = std::acos(static_cast<double>(glm::dot(a, b)) / static_cast<double>(glm::length(a) * glm::length(b)));
      if (angle <= widest + 1e-5) continue; // among equals the first counts, and acos of floats is not that exact
      widest = angle;
      expected = (uv[at(corner)] + uv[at(next_corner(corner))] + uv[at(previous_corner(corner))]) / 3.0f;
    }
    EXPECT_LT(glm::length(wedge.inside - expected), 1e-6f) << "point " << wedge.point;
  }
}

TEST(Charts, a_cube_of_six_charts_has_twelve_seam_edges) {
  const Built built = build(cube_of_six_charts());
  const Charts &charts = built.charts;
  EXPECT_EQ(charts.chart_count, 6);
  EXPECT_EQ(charts.triangle_chart, (std::vector<int32_t>{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5}));
  EXPECT_EQ(charts.seam_edges, 12);
  EXPECT_EQ(charts.self_seam_edges, 0);
  EXPECT_EQ(charts.unlinked_edges, 0);
  EXPECT_EQ(charts.flipped_triangles, 0);
  EXPECT_EQ(charts.borders.size(), 24u);
  EXPECT_EQ(count(charts, BorderKind::seam), 24);
}

TEST(Charts, every_seam_twin_runs_along_the_same_edge_in_the_other_direction) {
  const Built built = build(cube_of_six_charts());
  const auto start = [&](int h) { return built.triangles.positions[at(built.triangles.corner_vertex[at(h)])]; };
  for (const Border &border : built.charts.borders) {
    const Border &twin = built.charts.borders[at(border.twin)];
    EXPECT_NE(twin.chart, border.chart);
    EXPECT_EQ(start(border.half_edge), start(next_corner(twin.half_edge)));
    EXPECT_EQ(start(next_corner(border.half_edge)), start(twin.half_edge));
  }
}

TEST(Charts, a_corner_of_a_cube_has_a_wedge_on_each_of_its_three_charts) {
  const Built built = build(cube_of_six_charts());
  ASSERT_EQ(built.charts.wedges.size(), 24u);
  std::map<int32_t, std::set<int32_t>> charts_at;
  for (const Wedge &wedge : built.charts.wedges) {
    EXPECT_NEAR(wedge.angle, pi / 2, 1e-6); // (u, v) are floats
    charts_at[wedge.point].insert(wedge.chart);
  }
  ASSERT_EQ(charts_at.size(), 8u);
  for (const auto &[point, charts] : charts_at) EXPECT_EQ(charts.size(), 3u) << "point " << point;
}

TEST(Charts, of_equally_wide_wedges_the_first_is_chosen) {
  const Built built = build(cube_of_six_charts());
  for (int32_t point = 0; point < 8; ++point) {
    const int32_t chosen = built.charts.point_wedge[at(point)];
    for (int32_t earlier = 0; earlier < chosen; ++earlier) {
      const Wedge &wedge = built.charts.wedges[at(earlier)];
      EXPECT_TRUE(wedge.point != point || wedge.angle < built.charts.wedges[at(chosen)].angle);
    }
  }
}

TEST(Charts, vertices_split_by_an_exporter_change_nothing) {
  Shape shape = cube_of_six_charts();
  std::vector<vec3> positions;
  for (int32_t &vertex : shape.faces) {
    positions.push_back(shape.positions[at(vertex)]);
    vertex = static_cast<int32_t>(positions.size()) - 1;
  }
  shape.positions = positions;
  const Built built = build(shape);
  EXPECT_EQ(built.charts.chart_count, 6);
  EXPECT_EQ(built.charts.seam_edges, 12);
  EXPECT_EQ(built.charts.wedges.size(), 24u);
  EXPECT_EQ(count(built.charts, BorderKind::boundary), 0);
}

TEST(Charts, an_unrolled_cylinder_is_one_chart_with_a_seam_to_itself) {
  const Built built = build(cylinder(8, 3));
  const Charts &charts = built.charts;
  EXPECT_EQ(charts.chart_count, 1);
  EXPECT_EQ(charts.seam_edges, 3);
  EXPECT_EQ(charts.self_seam_edges, 3);
  EXPECT_EQ(count(charts, BorderKind::boundary), 16);
  EXPECT_EQ(count(charts, BorderKind::seam), 6);
  EXPECT_EQ(charts.wedges.size(), 9u * 4u) << "points on the seam have two wedges";
  for (const Border &border : charts.borders) {
    if (border.kind != BorderKind::seam) continue;
    const float u = built.triangles.corner_uv[at(border.half_edge)].x;
    const float other = built.triangles.corner_uv[at(charts.borders[at(border.twin)].half_edge)].x;
    EXPECT_EQ(std::min(u, other), 0);
    EXPECT_EQ(std::max(u, other), 1);
  }
}

TEST(Charts, triangles_mirrored_over_a_common_uv_edge_are_two_charts) {
  // Two triangles over an edge, folded onto each other in the UV map.
  const Shape shape = {{{0, 0, 0}, {1, 0, 0}, {0.5f, 1, 0}, {0.5f, -1, 0}},
                       {0, 1, 2, 1, 0, 3},
                       {{0, 0}, {1, 0}, {0.5f, 1}, {1, 0}, {0, 0}, {0.5f, 0.5f}}};
  const Built built = build(shape);
  EXPECT_EQ(built.charts.chart_count, 2);
  EXPECT_EQ(built.charts.seam_edges, 1);
  EXPECT_EQ(built.charts.self_seam_edges, 0);
  EXPECT_EQ(built.charts.flipped_triangles, 1);
  EXPECT_EQ(built.charts.wedges.size(), 6u);
}

TEST(Charts, a_layout_mirrored_as_a_whole_has_no_flipped_triangle) {
  Shape shape = grid(3, 2);
  for (vec2 &uv : shape.uvs) uv.x = 1 - uv.x;
  const Built built = build(shape);
  EXPECT_EQ(built.charts.chart_count, 1);
  EXPECT_EQ(built.charts.flipped_triangles, 0);
}

TEST(Charts, flipped_are_the_triangles_with_less_uv_area_though_they_are_more) {
  Shape shape = grid(2, 1); // the left quad shrinks to two small triangles wound the other way, the right keeps its half
  for (size_t corner = 0; corner < 6; ++corner)
    shape.uvs[corner] = vec2(0.1f - 0.1f * shape.uvs[corner].x, 0.1f * shape.uvs[corner].y);
  shape.positions.insert(shape.positions.end(), {{5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  shape.faces.insert(shape.faces.end(), {6, 7, 8});
  shape.uvs.insert(shape.uvs.end(), {{0.2f, 0}, {0.2f, 0.1f}, {0.3f, 0}});
  const Built built = build(shape);
  EXPECT_EQ(built.charts.flipped_triangles, 3);
  EXPECT_EQ(built.charts.chart_count, 3);
}

TEST(Charts, charts_on_the_same_texels_stay_apart) {
  Shape shape = grid(2, 1);
  for (size_t corner = 6; corner < 12; ++corner) shape.uvs[corner].x -= 0.5f; // the right quad lies on the left one
  const Built built = build(shape);
  EXPECT_EQ(built.charts.chart_count, 2);
  EXPECT_EQ(built.charts.seam_edges, 1);
}

TEST(Charts, uvs_agree_up_to_rounding_and_no_further) {
  for (const auto &[shift, chart_count] : {std::pair(5e-7f, 1), {1e-4f, 2}}) {
    Shape shape = grid(2, 1);
    for (size_t corner = 6; corner < 12; ++corner) shape.uvs[corner].x += shift;
    EXPECT_EQ(build(shape).charts.chart_count, chart_count) << "shift " << shift;
  }
}

TEST(Charts, faces_that_meet_in_one_end_only_of_their_edge_are_apart_there) {
  Shape shape = grid(1, 1);
  shape.uvs[3] += vec2(0.1f, 0.3f); // the second triangle's copy of vertex 0, one end of the diagonal
  const Built built = build(shape);
  EXPECT_EQ(built.charts.chart_count, 2);
  EXPECT_EQ(built.charts.seam_edges, 1);
}

TEST(Charts, a_triangle_without_uv_area_is_no_chart_and_its_neighbors_end_there) {
  Shape shape = grid(3, 3);
  const size_t inner = 2 * 4 * 3; // the first triangle of the middle quad
  for (size_t corner = inner; corner < inner + 3; ++corner) shape.uvs[corner] = vec2(0.5f);
  const Built built = build(shape);
  EXPECT_EQ(built.charts.zero_uv_area_triangles, 1);
  EXPECT_EQ(built.charts.triangle_chart[8], -1);
  EXPECT_EQ(built.charts.chart_count, 1);
  EXPECT_EQ(built.charts.unlinked_edges, 3);
  EXPECT_EQ(count(built.charts, BorderKind::unlinked), 3);
  EXPECT_EQ(built.charts.seam_edges, 0);
  for (int32_t wedge : built.charts.point_wedge) EXPECT_GE(wedge, 0);
}

TEST(Charts, slivers_as_thin_as_rounding_have_no_uv_area) {
  Shape shape = grid(1, 1);
  shape.uvs = {{0, 0}, {1, 0}, {0.5f, 5e-8f}, {0, 0}, {1e-8f, 0}, {0, 1e-8f}};
  const Built built = build(shape);
  EXPECT_EQ(built.charts.zero_uv_area_triangles, 2);
  EXPECT_EQ(built.charts.chart_count, 0);
}

TEST(Charts, small_but_sound_triangles_have_uv_area) {
  Shape shape = grid(10, 10);
  for (vec2 &uv : shape.uvs) uv *= 1e-4f;
  const Built built = build(shape);
  EXPECT_EQ(built.charts.zero_uv_area_triangles, 0);
  EXPECT_EQ(built.charts.borders.size(), 40u);
}

TEST(Charts, a_point_whose_faces_all_lack_uv_area_has_no_wedge) {
  Shape shape = grid(1, 1);
  for (size_t corner = 0; corner < 3; ++corner) shape.uvs[corner] = vec2(0);
  const Built built = build(shape);
  EXPECT_EQ(built.charts.point_wedge[at(built.half_edges.vertex_point[1])], -1); // of the first triangle alone
  EXPECT_GE(built.charts.point_wedge[at(built.half_edges.vertex_point[2])], 0);
  EXPECT_EQ(built.charts.wedges.size(), 3u);
}

TEST(Charts, degenerate_triangles_are_not_counted_again) {
  Shape shape = grid(1, 1);
  shape.faces.insert(shape.faces.end(), {0, 0, 1});
  shape.uvs.insert(shape.uvs.end(), {{0, 0}, {1, 0}, {0, 1}});
  const Built built = build(shape);
  EXPECT_EQ(built.charts.zero_uv_area_triangles, 0);
  EXPECT_EQ(built.charts.triangle_chart[2], -1);
  EXPECT_EQ(built.charts.chart_count, 1);
}

TEST(Charts, the_widest_wedge_of_a_point_is_chosen) {
  Shape shape = grid(2, 2); // the middle point: one quad apart (90 degrees), three together (270)
  for (size_t corner = 18; corner < 24; ++corner) shape.uvs[corner] = shape.uvs[corner] * 0.5f - vec2(0.25f);
  const Built built = build(shape);
  const Wedge &wedge = built.charts.wedges[at(built.charts.point_wedge[at(built.half_edges.vertex_point[4])])];
  EXPECT_EQ(wedge.chart, 0);
  EXPECT_NEAR(wedge.angle, 1.5 * pi, 1e-6);
  EXPECT_EQ(built.charts.seam_edges, 2);
}

TEST(Charts, the_chosen_wedge_does_not_depend_on_positions) {
  Shape shape = grid(2, 2); // as above; but the middle lies close to the one quad's far corner
  for (size_t corner = 18; corner < 24; ++corner) shape.uvs[corner] = shape.uvs[corner] * 0.5f - vec2(0.25f);
  const Built flat = build(shape);
  shape.positions[4] = vec3(0.95f, 0.95f, 0.0f);
  const Built moved = build(shape);
  EXPECT_EQ(moved.charts.point_wedge, flat.charts.point_wedge);
}

TEST(Charts, a_slit_within_a_chart_is_a_seam_of_the_chart_with_itself) {
  Shape shape = grid(2, 2); // quads 0 and 1 part along their common edge, but hang together over the other two
  for (size_t corner = 0; corner < 6; ++corner)
    if (shape.faces[corner] == 1) shape.uvs[corner].x -= 0.1f;
  const Built built = build(shape);
  EXPECT_EQ(built.charts.chart_count, 1);
  EXPECT_EQ(built.charts.seam_edges, 1);
  EXPECT_EQ(built.charts.self_seam_edges, 1);
  EXPECT_EQ(built.charts.wedges.size(), 10u) << "the open end of the slit has two wedges, its inner end one";
}

TEST(Charts, without_a_uv_map_there_are_no_charts) {
  Shape shape = grid(2, 1);
  shape.uvs.clear();
  const Built built = build(shape);
  EXPECT_EQ(built.charts.chart_count, 0);
  EXPECT_TRUE(built.charts.wedges.empty());
  EXPECT_TRUE(built.charts.borders.empty());
  EXPECT_EQ(built.charts.triangle_chart, std::vector<int32_t>(4, -1));
  EXPECT_EQ(built.charts.corner_wedge, std::vector<int32_t>(12, -1));
  EXPECT_EQ(built.charts.half_edge_border, std::vector<int32_t>(12, -1));
  EXPECT_EQ(built.charts.point_wedge, std::vector<int32_t>(6, -1));
  EXPECT_EQ(built.charts.zero_uv_area_triangles, 0);
}

} // namespace
} // namespace paradesc
