// Charts that overlap themselves → pieces that do not: few, connected, and found without fail.
#include "mesh/cut.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "bake/shapes.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

// A flat strip of `length` by `width` quads whose middle line follows `path` (t in [0, 1]) in the UV map, `reach` to either side.
Shape strip(int length, int width, double reach, const std::function<dvec2(double)> &path) {
  return grid(length, width, [=](dvec2 position, int, int) {
    const double t = position.x / length;
    dvec2 step = path(t + 1e-4) - path(t - 1e-4);
    if (step == dvec2(0)) step = path(t + 2e-3) - path(t); // it stands still at its start
    const dvec2 way = glm::normalize(step);
    return path(t) + dvec2(-way.y, way.x) * reach * (2.0 * position.y / width - 1.0);
  });
}

// Turns around the middle of the square, the radius growing by `pitch` a turn.
Shape spiral(double turns, double pitch, int length = 240) {
  return strip(length, 4, 0.06, [=](double t) {
    const double angle = 2 * pi * turns * t, radius = 0.2 + pitch * turns * t;
    return dvec2(0.5) + radius * dvec2(std::cos(angle), -std::sin(angle));
  });
}

// even: how evenly the quads are spread along it; at 3 they are a thousand times as long at its end as at its start.
Shape figure_eight(double even = 1) {
  return strip(160, 4, 0.05, [=](double t) {
    const double s = 0.3 + 2 * pi * 0.98 * std::pow(std::max(t, 1e-3), even); // ends do not meet
    return dvec2(0.5) + 0.4 * dvec2(std::sin(s), std::sin(s) * std::cos(s));
  });
}

// Triangles around a point whose angles in the UV map sum to `turns`.
Shape fan(int triangles, double turns) {
  Shape shape;
  shape.positions.push_back({0, 0, 1});
  for (int i = 0; i < triangles; ++i)
    shape.positions.push_back({std::cos(2 * pi * i / triangles), std::sin(2 * pi * i / triangles), 0});
  const auto rim = [&](int i) {
    return vec2(dvec2(0.5) + 0.4 * dvec2(std::cos(2 * pi * turns * i / triangles), std::sin(2 * pi * turns * i / triangles)));
  };
  for (int i = 0; i < triangles; ++i) {
    shape.faces.insert(shape.faces.end(), {0, 1 + i, 1 + (i + 1) % triangles});
    shape.uvs.insert(shape.uvs.end(), {vec2(0.5f), rim(i), rim(i + 1)});
  }
  return shape;
}

// The area that two triangles share: one is cut by the other's three edges.
double shared_area(const Built &built, int a, int b) {
  std::vector<dvec2> polygon{built.uv(3 * a), built.uv(3 * a + 1), built.uv(3 * a + 2)};
  const double turn = paradesc::cross(built.uv(3 * b + 1) - built.uv(3 * b), built.uv(3 * b + 2) - built.uv(3 * b)) < 0 ? -1 : 1;
  for (int i = 0; i < 3; ++i) {
    const dvec2 start = built.uv(3 * b + i), edge = built.uv(3 * b + (i + 1) % 3) - start;
    std::vector<dvec2> rest;
    for (size_t k = 0; k < polygon.size(); ++k) {
      const dvec2 p = polygon[k], q = polygon[(k + 1) % polygon.size()];
      const double side_p = turn * paradesc::cross(edge, p - start), side_q = turn * paradesc::cross(edge, q - start);
      if (side_p >= 0) rest.push_back(p);
      if ((side_p < 0) != (side_q < 0)) rest.push_back(p + (q - p) * (side_p / (side_p - side_q)));
    }
    polygon = rest;
  }
  double area = 0;
  for (size_t k = 0; k < polygon.size(); ++k) area += 0.5 * paradesc::cross(polygon[k], polygon[(k + 1) % polygon.size()]);
  return std::abs(area);
}

// Cuts, and checks what holds for all cuts: the pieces' triangles share no area, and charts of the pieces are the pieces.
Cuts checked_cuts(const Built &built) {
  const Cuts cuts = cut_charts(built.half_edges, built.charts);
  double largest = 0;
  for (int a = 0; a < built.triangles.triangle_count; ++a) {
    EXPECT_EQ(cuts.triangle_piece[at(a)] < 0, built.charts.triangle_chart[at(a)] < 0);
    for (int b = 0; b < a; ++b)
      if (cuts.triangle_piece[at(a)] >= 0 && cuts.triangle_piece[at(a)] == cuts.triangle_piece[at(b)])
        largest = std::max(largest, shared_area(built, a, b));
  }
  EXPECT_LT(largest, 2e-6 * 0.1) << "a hair along the sides, a tenth of the square long at most here";
  const Charts charts = build_charts(built.triangles, built.half_edges, cuts.triangle_piece);
  EXPECT_EQ(charts.triangle_chart.size(), cuts.triangle_piece.size());
  const int pieces = 1 + *std::max_element(cuts.triangle_piece.begin(), cuts.triangle_piece.end());
  EXPECT_EQ(charts.chart_count, pieces) << "pieces are connected";
  std::vector<int32_t> chart_of(at(pieces), -1);
  for (size_t t = 0; t < charts.triangle_chart.size(); ++t) {
    if (cuts.triangle_piece[t] < 0) continue;
    int32_t &chart = chart_of[at(cuts.triangle_piece[t])];
    if (chart < 0) chart = charts.triangle_chart[t];
    EXPECT_EQ(chart, charts.triangle_chart[t]);
  }
  EXPECT_EQ(cut_charts(built.half_edges, built.charts).triangle_piece, cuts.triangle_piece) << "the same again";
  return cuts;
}

// The two largest pieces' share of the triangles.
double share_of_two(const Cuts &cuts) {
  std::vector<double> share;
  for (const int32_t piece : cuts.triangle_piece) {
    if (piece < 0) continue; // without area
    share.resize(std::max(share.size(), at(piece) + 1));
    share[at(piece)] += 1.0 / static_cast<double>(cuts.triangle_piece.size());
  }
  std::sort(share.rbegin(), share.rend());
  return share[0] + share[1];
}

int pieces_of(const Cuts &cuts) { return 1 + *std::max_element(cuts.triangle_piece.begin(), cuts.triangle_piece.end()); }

TEST(Cut, charts_that_only_touch_are_left_alone) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 1000});
  lay_out(mesh, {.charts = 24, .warp = 0.3});
  const Built built = build(mesh);
  const Cuts cuts = checked_cuts(built);
  EXPECT_FALSE(cuts.overlapping);
  EXPECT_EQ(cuts.cut_charts, 0);
  EXPECT_EQ(pieces_of(cuts), built.charts.chart_count);
}

TEST(Cut, a_spiral_beside_itself_is_left_alone) {
  const Cuts cuts = checked_cuts(build(spiral(1.9, 0.125)));
  EXPECT_FALSE(cuts.overlapping);
  EXPECT_EQ(pieces_of(cuts), 1);
}

TEST(Cut, a_spiral_of_three_turns_on_one_ring_is_three_or_four_pieces) {
  const Cuts cuts = checked_cuts(build(spiral(3, 0)));
  EXPECT_TRUE(cuts.overlapping);
  EXPECT_EQ(cuts.cut_charts, 1);
  EXPECT_GE(pieces_of(cuts), 3);
  EXPECT_LE(pieces_of(cuts), 4);
}

TEST(Cut, a_spiral_half_over_itself_is_a_few_pieces) {
  const Cuts cuts = checked_cuts(build(spiral(3, 0.06)));
  EXPECT_EQ(cuts.cut_charts, 1);
  EXPECT_GE(pieces_of(cuts), 2);
  EXPECT_LE(pieces_of(cuts), 4);
}

TEST(Cut, a_strip_over_itself_many_times_is_as_many_pieces) {
  const Built built = build(spiral(50, 0, 2000));
  const Cuts cuts = cut_charts(built.half_edges, built.charts);
  EXPECT_GE(pieces_of(cuts), 50);
  EXPECT_LE(pieces_of(cuts), 53);
}

TEST(Cut, a_figure_eight_is_cut_where_it_crosses_itself) {
  const Built built = build(figure_eight());
  const Cuts cuts = checked_cuts(built);
  EXPECT_EQ(cuts.cut_charts, 1);
  EXPECT_LE(pieces_of(cuts), 8) << "single triangles may come off at the crossing";
  EXPECT_GT(share_of_two(cuts), 0.99);
}

TEST(Cut, triangles_around_a_point_for_two_turns_are_two_pieces) {
  EXPECT_FALSE(checked_cuts(build(fan(12, 1.0))).overlapping);
  const Cuts cuts = checked_cuts(build(fan(24, 2.0)));
  EXPECT_EQ(cuts.cut_charts, 1);
  EXPECT_GE(pieces_of(cuts), 2);
  EXPECT_LE(pieces_of(cuts), 3);
}

TEST(Cut, charts_on_each_other_are_found_and_not_cut) {
  const Built built = build(grid(2, 1, [](dvec2 position, int x, int) { return dvec2(position.x - x, position.y); }));
  ASSERT_EQ(built.charts.chart_count, 2);
  const Cuts cuts = checked_cuts(built);
  EXPECT_TRUE(cuts.overlapping);
  EXPECT_EQ(cuts.cut_charts, 0);
}

TEST(Cut, triangles_stacked_over_their_edge_are_two_charts_on_each_other) {
  const Built built = build(Shape{{{0, 0, 0}, {1, 0, 0}, {0.5f, 1, 0}, {0.5f, -1, 0}},
                                  {0, 1, 2, 1, 0, 3},
                                  {{0, 0}, {1, 0}, {0.5f, 1}, {1, 0}, {0, 0}, {0.5f, 1}}});
  const Cuts cuts = checked_cuts(built);
  EXPECT_TRUE(cuts.overlapping);
  EXPECT_EQ(cuts.cut_charts, 0);
  EXPECT_EQ(pieces_of(cuts), 2);
}

TEST(Cut, small_triangles_over_large_ones_are_found) {
  const Cuts cuts = checked_cuts(build(figure_eight(3)));
  EXPECT_EQ(cuts.cut_charts, 1);
  EXPECT_LE(pieces_of(cuts), 8) << "single triangles may come off at the crossing";
  EXPECT_GT(share_of_two(cuts), 0.99);
}

// A hundred by a hundred quads; what lies at one inner vertex is moved along u by this part of a quad.
Shape dented_grid(int x, int y, double part) {
  return grid(100, 100,
              [=](dvec2 position, int, int) { return (position + dvec2(position == dvec2(x, y) ? part : 0.0, 0.0)) / 100.0; });
}

TEST(Cut, one_overlap_among_twenty_thousand_triangles_is_found_wherever_it_lies) {
  for (const auto &[x, y] : {std::pair(1, 1), std::pair(98, 98), std::pair(50, 33), std::pair(99, 1), std::pair(17, 64)}) {
    const Built sound = build(dented_grid(x, y, 0.9)), folded = build(dented_grid(x, y, 1.2));
    EXPECT_FALSE(cut_charts(sound.half_edges, sound.charts).overlapping) << x << ", " << y;
    EXPECT_TRUE(cut_charts(folded.half_edges, folded.charts).overlapping) << x << ", " << y;
  }
}

// Boxes of all of these are the whole square.
TEST(Cut, long_triangles_across_the_square_are_left_alone) {
  const Cuts cuts = checked_cuts(build(grid(1, 400, [](dvec2 position, int, int) {
    return dvec2(0.1, 0.0) + position.x * dvec2(0.8) + position.y / 400.0 * dvec2(-0.1, 0.1);
  })));
  EXPECT_FALSE(cuts.overlapping);
  EXPECT_EQ(pieces_of(cuts), 1);
}

TEST(Cut, triangles_on_no_chart_belong_to_no_piece) {
  Shape shape = grid(3, 3, [](dvec2 position, int, int) { return position / 3.0; });
  for (size_t corner = 24; corner < 27; ++corner) shape.uvs[corner] = vec2(0.5f);
  const Cuts cuts = checked_cuts(build(shape));
  EXPECT_EQ(cuts.triangle_piece[8], -1);
  EXPECT_FALSE(cuts.overlapping);
}

TEST(Cut, charts_end_between_pieces_by_a_seam_and_nowhere_else) {
  const Built built = build(spiral(3, 0));
  const Cuts cuts = cut_charts(built.half_edges, built.charts);
  const Charts charts = build_charts(built.triangles, built.half_edges, cuts.triangle_piece);
  int between = 0;
  for (size_t h = 0; h < built.half_edges.twin.size(); ++h) {
    const int32_t twin = built.half_edges.twin[h];
    if (twin < 0) continue;
    const bool apart = cuts.triangle_piece[h / 3] != cuts.triangle_piece[at(twin / 3)];
    EXPECT_EQ(charts.half_edge_border[h] >= 0, apart);
    if (apart) {
      EXPECT_EQ(charts.borders[at(charts.half_edge_border[h])].kind, BorderKind::seam);
    }
    between += apart;
  }
  EXPECT_EQ(charts.seam_edges, between / 2);
  EXPECT_EQ(build_charts(built.triangles, built.half_edges).seam_edges, 0);
}

} // namespace
} // namespace paradesc::test
