// Closed parts whose outside is inside.
#include "mesh/winding.h"

#include <gtest/gtest.h>

#include "support/triangle_lists.h"

namespace paradesc::test {
namespace {

using namespace shapes;

Shape scaled(Shape shape, float size, vec3 offset) {
  for (vec3 &p : shape.positions) p = size * p + offset;
  return shape;
}

int inward_parts(const Shape &shape) {
  const Triangles triangles = triangles_of(shape);
  const HalfEdges half_edges = build_half_edges(triangles);
  return count_inward_parts(triangles, half_edges, bounding_box(triangles, half_edges));
}

TEST(Winding, closed_parts_wound_inwards_are_counted) {
  EXPECT_EQ(inward_parts(cube()), 0);
  EXPECT_EQ(inward_parts(turned_over(cube())), 1);
  EXPECT_EQ(inward_parts(turned_over(cube(vec3(1e4f)))), 1);
  EXPECT_EQ(inward_parts(join(cube(), turned_over(cube({3, 0, 0})))), 1);
  EXPECT_EQ(inward_parts(turned_over(join(cube(), cube({3, 0, 0})))), 2);
}

TEST(Winding, the_hollow_of_a_solid_is_wound_inwards_rightly) {
  const Shape hollow = turned_over(scaled(cube(), 0.5f, vec3(0.25f)));
  EXPECT_EQ(inward_parts(join(cube(), hollow)), 0);
  EXPECT_EQ(inward_parts(turned_over(join(cube(), hollow))), 1) << "its outer side";
}

TEST(Winding, open_parts_and_those_without_volume_are_not_counted) {
  EXPECT_EQ(inward_parts(turned_over(grid(3, 3))), 0);
  Shape open = turned_over(cube());
  open.faces.resize(open.faces.size() - 3);
  EXPECT_EQ(inward_parts(open), 0);
  const Shape pillow = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0, 1, 2, 0, 2, 3, 1, 0, 3, 1, 3, 2}};
  EXPECT_EQ(inward_parts(pillow), 0);
}

} // namespace
} // namespace paradesc::test
