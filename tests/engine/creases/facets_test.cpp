// Facets against the triangles that they stand for, and how little of a solid's sides is left of them.
#include "engine/creases/solid.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "support/creases.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

struct Subject {
  Triangles triangles;
  HalfEdges half_edges;
  Creases creases;
  Normals normals;
  Facets facets, none;

  explicit Subject(Triangles list)
      : triangles(std::move(list)), half_edges(build_half_edges(triangles)), creases(creases_of(triangles, half_edges)) {
    normals = compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges, creases), PDESC_NORMALS_FITTED, 0);
    facets = find_facets(triangles, half_edges, normals, creases);
    none = no_facets(triangles);
  }

  CreasedSurface surface(const Facets &of) const { return {triangles, half_edges, normals, creases, of}; }

  // At each point and in the middle of every seventh triangle.
  std::vector<SolidTensor> tensors(const Facets &of, double radius) const {
    const SolidSurface shared(surface(of), radius);
    SolidMeasure measure(shared);
    std::vector<SolidTensor> found;
    const auto look = [&](dvec3 position, dvec3 normal, int32_t triangle, int32_t point) {
      const dvec3 t1 = tangent_of(normal);
      measure.is_near_crease(position, triangle);
      found.push_back(measure.at({position, normal, t1, glm::cross(normal, t1), triangle, point}));
    };
    for (int32_t point = 0; point < half_edges.point_count; ++point)
      look(dvec3(triangles.positions[half_edges.point_vertex[point]]), glm::normalize(dvec3(normals.point[point])),
           half_edges.point_half_edge[point] / 3, point);
    for (int32_t t = 0; t < triangles.triangle_count; t += 7)
      look((dvec3(triangles.position(3 * t)) + dvec3(triangles.position(3 * t + 1)) + dvec3(triangles.position(3 * t + 2))) / 3.0,
           steady_normal(triangles, half_edges, t), t, -1);
    return found;
  }

  // Expects what facets give to be what triangles give, in units of 1 over the radius.
  void expect_alike(double radius, double tolerance) const {
    const std::vector<SolidTensor> fast = tensors(facets, radius), slow = tensors(none, radius);
    int beside = 0;
    for (size_t i = 0; i < fast.size(); ++i) {
      ASSERT_NEAR(fast[i].weight, slow[i].weight, 1e-5) << i; // rounding of positions, over a quarter of the radius
      ASSERT_NEAR(fast[i].xx * radius, slow[i].xx * radius, tolerance) << i;
      ASSERT_NEAR(fast[i].xy * radius, slow[i].xy * radius, tolerance) << i;
      ASSERT_NEAR(fast[i].yy * radius, slow[i].yy * radius, tolerance) << i;
      beside += slow[i].weight > 0;
    }
    EXPECT_GT(beside, 20);
  }
};

// Its points moved along its sides, where they are not on edges, so that no two triangles are alike; then turned in space.
Triangles uneven_box(int cells) {
  Triangles uneven = box(cells);
  Random random(3);
  const Rotation turn = rotation_about({1, 2, 4}, 0.7);
  for (vec3 &p : uneven.positions) {
    int on = 0;
    for (int k = 0; k < 3; ++k) on += std::abs(p[k]) > 0.999f;
    dvec3 moved(p);
    for (int k = 0; k < 3 && on == 1; ++k)
      if (std::abs(p[k]) < 0.999f) moved[k] += random.uniform(-0.3, 0.3) / cells;
    const Vec3 turned = turn({moved.x, moved.y, moved.z});
    p = {turned.x, turned.y, turned.z};
  }
  return uneven;
}

TEST(Facets, of_a_box_are_its_sides) {
  for (const int cells : {4, 16}) {
    const Subject subject(uneven_box(cells));
    EXPECT_EQ(subject.facets.facet.size(), 6u);
    EXPECT_EQ(subject.facets.side.size(), 24u);
    EXPECT_EQ(subject.facets.outline.size(), 24u * static_cast<size_t>(cells));
    for (const Facet &facet : subject.facets.facet) EXPECT_TRUE(facet.is_convex);
    for (const FacetSide &side : subject.facets.side) EXPECT_NEAR(side.bend, 0.5 * pi, 1e-6);
  }
}

TEST(Facets, of_a_smooth_surface_there_are_none) {
  EXPECT_TRUE(Subject(read_triangles(input_of(torus(1, 0.4, {.vertices = 3000})))).facets.facet.empty());
}

TEST(Facets, stand_for_their_triangles) {
  const Subject box_(uneven_box(12)), bevelled(bevelled_box(0.15)), cylinder(prism(24, 12, 6));
  EXPECT_GE(cylinder.facets.facet.size(), 2u);
  for (const double r : {0.1, 0.3, 0.7}) {
    box_.expect_alike(r, 2e-5); // bends of triangles, rounded
    bevelled.expect_alike(r, 2e-5);
  }
  cylinder.expect_alike(0.3, 3e-5); // single triangles count where they are small at a few points of theirs
}

// Triangles that reach far out of the ball count in double precision, others in lanes of floats.
TEST(Facets, stand_for_large_triangles) {
  const Subject subject(uneven_box(3));
  for (const double r : {0.01, 0.05, 0.1, 0.13}) subject.expect_alike(r, 2e-5);
}

// A box whose top is pushed down where it is near its middle.
Subject pushed_in(vec2 half, float bottom) {
  Triangles list = box(10);
  for (vec3 &p : list.positions)
    if (p.z > 0.99f && std::abs(p.x) < half.x && std::abs(p.y) < half.y) p.z = bottom;
  return Subject(std::move(list));
}

// The top around a pit, and around a slot so deep that a ball beside it cuts two parts out of the top, of which it reaches one.
TEST(Facets, that_are_not_convex_stand_for_their_triangles) {
  const Subject pit = pushed_in({0.7f, 0.5f}, 0.7f), slot = pushed_in({0.1f, 0.7f}, -0.2f);
  for (const Subject *subject : {&pit, &slot})
    EXPECT_TRUE(std::ranges::any_of(subject->facets.facet, [](const Facet &facet) { return !facet.is_convex; }));
  for (const double r : {0.25, 0.9, 3.0}) pit.expect_alike(r, 2e-5);
  slot.expect_alike(0.45, 2e-5);
}

} // namespace
} // namespace paradesc::test
