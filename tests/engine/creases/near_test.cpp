// Places near a crease of their own component, against the distance from every crease.
#include "engine/creases/near.h"

#include <gtest/gtest.h>

#include "kernel/limits.h"
#include "support/creases.h"
#include "support/solids.h"

namespace paradesc::test {
namespace {

// A box of many cells, and small ones in rows through it and beside it.
Triangles boxes() {
  std::vector<vec3> positions;
  std::vector<int32_t> corners;
  const auto add = [&](const Triangles &from, float size, vec3 middle) {
    const auto first = static_cast<int32_t>(positions.size());
    for (const vec3 &position : from.positions) positions.push_back(size * position + middle);
    for (const int32_t vertex : from.corner_vertex) corners.push_back(first + vertex);
  };
  add(box(12), 1.0f, vec3(0));
  for (int i = 0; i < 20; ++i)
    add(box(1), 0.05f, vec3(0.12f * static_cast<float>(i) - 1.1f, 0.02f * static_cast<float>(i % 3), 0.3f));
  return shape(positions, corners);
}

TEST(NearCreases, are_those_of_the_own_component_within_reach) {
  const Triangles triangles = boxes();
  const HalfEdges half_edges = build_half_edges(triangles);
  const Creases creases = creases_of(triangles, half_edges);
  const Normals normals =
      compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges, creases), PDESC_NORMALS_FITTED, 0);
  const Facets facets = find_facets(triangles, half_edges, normals, creases);
  ASSERT_EQ(creases.edges.size(), 12u * 12 + 12 * 20);
  int near_ones = 0, far_ones = 0;
  std::vector<NearCrease> found;
  for (const double radius : {0.004, 0.05, 0.2, 5.0}) {
    const NearCreases near({triangles, half_edges, normals, creases, facets}, radius);
    for (int32_t t = 0; t < triangles.triangle_count; ++t) {
      const dvec3 place = (dvec3(triangles.position(3 * t)) + 2.0 * dvec3(triangles.position(3 * t + 1)) +
                           3.0 * dvec3(triangles.position(3 * t + 2))) /
                          6.0;
      bool expected = false;
      for (const int32_t edge : creases.edges)
        expected = expected || (half_edges.triangle_piece[edge / 3] == half_edges.triangle_piece[t] &&
                                segment_distance(dvec3(triangles.position(edge)) - place,
                                                 dvec3(triangles.position(next_corner(edge))) - place) < CREASE_REACH * radius);
      near.find(place, t, found);
      ASSERT_EQ(!found.empty(), expected) << t << " at " << radius;
      ++(expected ? near_ones : far_ones);
    }
  }
  EXPECT_GT(near_ones, 500);
  EXPECT_GT(far_ones, 500);
}

} // namespace
} // namespace paradesc::test
