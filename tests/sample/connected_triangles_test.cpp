// The triangles that are connected to a point within a ball.
#include "sample/connected_triangles.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "support/solids.h"

namespace paradesc::test {
namespace {

// A strip of squares, folded like a hairpin: two legs of `length` squares, a gap apart, joined by one square across their end.
struct Hairpin {
  static constexpr int length = 20;
  static constexpr float gap = 0.5f; // squares have side 1
  Triangles triangles;
  HalfEdges half_edges;

  Hairpin() {
    const int rows = 2 * (length + 1);
    std::vector<vec3> positions;
    for (int row = 0; row < rows; ++row)
      for (int side = 0; side < 2; ++side) {
        const bool back = row > length;
        positions.emplace_back(back ? rows - 1 - row : row, side, back ? gap : 0.0f);
      }
    std::vector<int32_t> corners;
    for (int32_t row = 0; row + 1 < rows; ++row)
      corners.insert(corners.end(), {2 * row, 2 * row + 2, 2 * row + 1, 2 * row + 1, 2 * row + 2, 2 * row + 3});
    triangles = shape(positions, corners);
    half_edges = build_half_edges(triangles);
  }

  int32_t point_at(int row) const { return half_edges.vertex_point[static_cast<size_t>(2 * row)]; }
  std::vector<int32_t> reached(int row, double radius, size_t limit = 1000) const {
    const std::vector<int32_t> points{point_at(row)};
    const ConnectedTriangles connected = ConnectedTriangleSearch(triangles, half_edges, radius, limit, 1).run(points);
    EXPECT_EQ(connected.begin, (std::vector<int32_t>{0, static_cast<int32_t>(connected.triangle.size())}));
    return connected.triangle;
  }
};

// The other leg is nearer than the radius all along, but the way to it leads around the end.
TEST(ConnectedTriangles, other_leg_of_a_hairpin_is_not_reached_far_from_its_end) {
  const Hairpin hairpin;
  const std::vector<int32_t> found = hairpin.reached(10, 3.0);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(found.back(), 2 * Hairpin::length) << "triangles are numbered along the strip";
  // Squares 7 to 12 lie within 3 of row 10, and those beside them meet the ball in an edge at most.
  for (const int square : {7, 8, 9, 10, 11, 12})
    for (const int triangle : {2 * square, 2 * square + 1})
      EXPECT_TRUE(std::binary_search(found.begin(), found.end(), triangle)) << triangle;
  EXPECT_GE(found.front(), 2 * 6);
  EXPECT_LE(found.back(), 2 * 13 + 1);
}

TEST(ConnectedTriangles, other_leg_is_reached_around_the_end) {
  const Hairpin hairpin;
  const std::vector<int32_t> found = hairpin.reached(Hairpin::length - 1, 3.0);
  EXPECT_TRUE(std::binary_search(found.begin(), found.end(), 2 * Hairpin::length)); // across
  EXPECT_GT(found.back(), 2 * Hairpin::length + 2);                                 // and back
}

// The area of the leg within the ball is that of a disk's middle strip, 2 sqrt(r^2 - y^2) integrated over y in [0, 1].
TEST(ConnectedTriangles, area_is_that_of_the_triangles_within_the_ball) {
  const Hairpin hairpin;
  const std::vector<int32_t> points{hairpin.point_at(10)};
  const double r = 3.0;
  const ConnectedTriangles connected = ConnectedTriangleSearch(hairpin.triangles, hairpin.half_edges, r, 1000, 1).run(points);
  EXPECT_NEAR(connected.area[0], std::sqrt(r * r - 1) + r * r * std::asin(1 / r), 0.03 * 2 * r); // "to a few per cent"
}

// A point before a long edge whose ends lie far outside of the ball; behind it another triangle, and behind that one a third.
TEST(ConnectedTriangles, an_edge_that_passes_through_the_ball_is_crossed) {
  const Triangles triangles = shape({{0, 0, 0}, {-5, 0.5f, 0}, {5, 0.5f, 0}, {0, 6, 0}, {9, 6, 0}}, {0, 2, 1, 1, 2, 3, 3, 2, 4});
  const HalfEdges half_edges = build_half_edges(triangles);
  const std::vector<int32_t> points{half_edges.vertex_point[0]};
  EXPECT_EQ(ConnectedTriangleSearch(triangles, half_edges, 1.0, 100, 1).run(points).triangle, (std::vector<int32_t>{0, 1}));
}

// One over it is no number: a point is not even near itself.
TEST(ConnectedTriangles, a_radius_below_all_floats_reaches_nothing) { EXPECT_TRUE(Hairpin().reached(10, 1e-45).empty()); }

TEST(ConnectedTriangles, triangles_are_sorted_and_come_once) {
  const Hairpin hairpin;
  const std::vector<int32_t> found = hairpin.reached(Hairpin::length, 6.0);
  EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
  EXPECT_EQ(std::set<int32_t>(found.begin(), found.end()).size(), found.size());
}

TEST(ConnectedTriangles, more_triangles_than_the_limit_are_left_to_the_cells) {
  const Hairpin hairpin;
  EXPECT_FALSE(hairpin.reached(10, 3.0, 30).empty());
  EXPECT_TRUE(hairpin.reached(10, 3.0, 5).empty());
}

// A point may come twice, in any order: once for each of its two wedges.
TEST(ConnectedTriangles, each_of_many_points_finds_what_it_finds_alone) {
  const Hairpin hairpin;
  std::vector<int32_t> points;
  std::vector<std::vector<int32_t>> alone;
  for (int i = 0; i < 600; ++i) {
    const int row = i * 7 % (2 * Hairpin::length);
    points.push_back(hairpin.point_at(row));
    alone.push_back(hairpin.reached(row, 2.5));
  }
  for (const int threads : {1, 2}) {
    const ConnectedTriangles connected =
        ConnectedTriangleSearch(hairpin.triangles, hairpin.half_edges, 2.5, 1000, threads).run(points);
    for (size_t i = 0; i < points.size(); ++i)
      EXPECT_EQ(std::vector<int32_t>(connected.triangle.begin() + connected.begin[i],
                                     connected.triangle.begin() + connected.begin[i + 1]),
                alone[i]);
  }
}

// Points of both legs by turns: they lie near each other, so that their floods are shared, and the surface leads from the one to
// the other outside of their balls, or near the end within.
TEST(ConnectedTriangles, points_that_share_a_flood_find_what_they_find_alone) {
  const Hairpin hairpin;
  const double radius = 3.0;
  std::vector<int32_t> points;
  for (int row = 0; row <= Hairpin::length; ++row)
    for (const int row_of_leg : {row, 2 * Hairpin::length + 1 - row}) points.push_back(hairpin.point_at(row_of_leg));
  ConnectedTriangleSearch search(hairpin.triangles, hairpin.half_edges, radius, 1000, 2);
  const ConnectedTriangles together = search.run(points);
  std::vector<double> areas(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const ConnectedTriangles alone = search.run({&points[i], 1});
    EXPECT_EQ(
        std::vector<int32_t>(together.triangle.begin() + together.begin[i], together.triangle.begin() + together.begin[i + 1]),
        alone.triangle)
        << i;
    EXPECT_NEAR(together.area[i], alone.area[0], 1e-5 * alone.area[0]) << i;
    EXPECT_GT(alone.area[0], 0.0);
    areas[i] = i % 3 == 0 ? 2.0 * alone.area[0] : alone.area[0];
  }
  const ConnectedTriangles unexpected = search.run(points, {areas, 0.01});
  for (size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(unexpected.begin[i + 1] - unexpected.begin[i], i % 3 == 0 ? together.begin[i + 1] - together.begin[i] : 0) << i;
}

// The other leg reaches the limit sooner near the end than far from it.
TEST(ConnectedTriangles, the_limit_is_that_of_each_point_that_shares_a_flood) {
  const Hairpin hairpin;
  std::vector<int32_t> points;
  for (int row = 0; row <= Hairpin::length; ++row) points.push_back(hairpin.point_at(row));
  const size_t limit = 26;
  const ConnectedTriangles connected = ConnectedTriangleSearch(hairpin.triangles, hairpin.half_edges, 5.0, limit, 1).run(points);
  size_t none = 0;
  for (int row = 0; row <= Hairpin::length; ++row) {
    const std::vector<int32_t> alone = hairpin.reached(row, 5.0, 1000);
    const auto i = static_cast<size_t>(row);
    EXPECT_EQ(static_cast<size_t>(connected.begin[i + 1] - connected.begin[i]), alone.size() > limit ? 0 : alone.size()) << row;
    none += alone.size() > limit;
  }
  EXPECT_GT(none, 0u);
  EXPECT_LT(none, points.size());
}

// Flat squares of side 1, each cut in two, whose vertices are moved at random.
struct UnevenPlane {
  static constexpr int side = 40; // squares
  Triangles triangles;
  HalfEdges half_edges;

  UnevenPlane() {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> moved(-0.3f, 0.3f);
    std::vector<vec3> positions;
    for (int y = 0; y <= side; ++y)
      for (int x = 0; x <= side; ++x) {
        const float across = static_cast<float>(x) + moved(random), along = static_cast<float>(y) + moved(random);
        positions.emplace_back(across, along, 0.0f);
      }
    std::vector<int32_t> corners;
    for (int32_t y = 0; y < side; ++y)
      for (int32_t x = 0; x < side; ++x) {
        const int32_t at = y * (side + 1) + x;
        corners.insert(corners.end(), {at, at + 1, at + side + 1, at + side + 1, at + 1, at + side + 2});
      }
    triangles = shape(positions, corners);
    half_edges = build_half_edges(triangles);
  }

  // At least 15 squares from its border.
  std::vector<int32_t> points_inside() const {
    std::vector<int32_t> points;
    for (int32_t y = 15; y <= side - 15; ++y)
      for (int32_t x = 15; x <= side - 15; ++x)
        points.push_back(half_edges.vertex_point[static_cast<size_t>(y * (side + 1) + x)]);
    return points;
  }
};

// What the rim cuts is measured in three ways, by how large triangles are.
TEST(ConnectedTriangles, areas_on_a_plane_are_those_of_disks_whatever_the_size_of_triangles) {
  const UnevenPlane plane;
  const std::vector<int32_t> points = plane.points_inside();
  struct Case {
    double radius;
    double largest, mean; // errors, of the disk's area; least where the rim is taken for straight within each triangle
  };
  for (const Case &expected :
       {Case{14, 0.02, 0.002}, {8, 0.02, 0.002}, {5, 0.005, 0.001}, {3, 0.008, 0.002}, {2, 0.025, 0.002}, {1, 0.08, 0.003}}) {
    const double disk = pi * expected.radius * expected.radius;
    const ConnectedTriangles connected =
        ConnectedTriangleSearch(plane.triangles, plane.half_edges, expected.radius, 8191, 1).run(points);
    double largest = 0.0, sum = 0.0;
    for (const double area : connected.area) {
      largest = std::max(largest, std::abs(area / disk - 1.0));
      sum += area / disk - 1.0;
    }
    EXPECT_LT(largest, expected.largest) << expected.radius;
    EXPECT_LT(std::abs(sum) / static_cast<double>(points.size()), expected.mean) << expected.radius;
  }
}

} // namespace
} // namespace paradesc::test
