// Places of vertices: equal positions, and such as differ by rounding alone beside open edges.
#include "mesh/weld.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "support/triangle_lists.h"

namespace paradesc::test {
namespace {

using namespace shapes;

TEST(Weld, positions_are_one_place_where_they_are_equal) {
  const Places places =
      weld(triangles_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-0.0f, 0, -0.0f}, {0, 0, 1}}, {0, 1, 2, 3, 4, 5}}));
  EXPECT_EQ(places.of_vertex, (std::vector<int32_t>{0, 1, 2, 1, 0, 5})) << "minus zero is zero";
  EXPECT_EQ(places.of_corner, (std::vector<int32_t>{0, 1, 2, 1, 0, 5}));
  EXPECT_FALSE(weld(triangles_of(cube())).are_shared());
}

// Every corner moves by up to so many units in the last place of 1.
Shape jittered(Shape shape, int units) {
  std::mt19937 random(3);
  const int ways = 2 * units + 1;
  for (vec3 &p : shape.positions)
    for (int axis = 0; axis < 3; ++axis) {
      const int steps = static_cast<int>(random() % static_cast<unsigned>(ways)) - units;
      p[axis] += static_cast<float>(steps) * std::numeric_limits<float>::epsilon();
    }
  return shape;
}

TEST(Weld, corners_of_a_soup_that_differ_in_the_last_bits_meet) {
  for (const int units : {1, 2, 8}) { // two that move by 8 differ by 16 at most
    const HalfEdges half_edges = build(jittered(split(cube()), units));
    expect_no_defect(half_edges);
    EXPECT_EQ(half_edges.point_count, 8) << units;
    EXPECT_EQ(half_edges.boundary_edges, 0) << units;
    EXPECT_EQ(half_edges.welded_vertices, 36 - 8) << units;
  }
}

TEST(Weld, corners_farther_apart_than_rounding_do_not_meet) {
  Shape shape = split(grid(1, 1)); // the diagonal runs from (0, 0) to (1, 1)
  shape.positions[3].x += 40 * std::numeric_limits<float>::epsilon();
  EXPECT_EQ(build(shape).boundary_edges, 6);
}

TEST(Weld, sheets_a_hundred_units_in_the_last_place_apart_stay_apart) {
  Shape back = turned_over(grid(3, 2));
  for (vec3 &p : back.positions) p.z -= 300 * std::numeric_limits<float>::epsilon(); // the largest coordinate is 3
  const HalfEdges half_edges = build(join(grid(3, 2), back));
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(half_edges.boundary_edges, 20);
  EXPECT_EQ(half_edges.welded_vertices, 0);
}

TEST(Weld, a_mesh_whose_edges_are_a_few_units_in_the_last_place_long_keeps_its_vertices) {
  Shape shape = grid(6, 6);
  for (vec3 &p : shape.positions) p = vec3(4194304) + 0.5f * vec3(p.x, p.y, 0); // coordinates of a map, to half a meter
  for (const Shape &variant : {shape, split(shape)}) {
    const HalfEdges half_edges = build(variant);
    expect_no_defect(half_edges);
    EXPECT_EQ(half_edges.point_count, 49);
    EXPECT_EQ(half_edges.boundary_edges, 24);
  }
}

TEST(Weld, a_bridge_narrower_than_rounding_keeps_its_width) {
  // Two squares and a strip between them, of two triangles with an edge of 4 units across.
  const float narrow = 4 * std::numeric_limits<float>::epsilon();
  const Shape shape = {{{-1, -1, 0}, {0, 0, 0}, {0, narrow, 0}, {-1, 1, 0}, {1, -1, 0}, {1, 1, 0}},
                       {0, 1, 2, 0, 2, 3, 1, 4, 2, 4, 5, 2}};
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.point_count, 6);
  EXPECT_EQ(half_edges.components, 1);
}

} // namespace
} // namespace paradesc::test
