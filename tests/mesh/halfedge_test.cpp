// Half-edges of sound, split, touching and non-manifold meshes.
#include "mesh/halfedge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "support/triangle_lists.h"

namespace paradesc::test {
namespace {

using namespace shapes;

TEST(HalfEdge, a_tetrahedron_is_closed) {
  const HalfEdges half_edges = build(tetrahedron());
  expect_no_defect(half_edges);
  EXPECT_EQ(half_edges.point_count, 4);
  EXPECT_EQ(open_half_edges(half_edges), 0);
  EXPECT_EQ(half_edges.boundary_edges, 0);
  EXPECT_EQ(half_edges.components, 1);
  EXPECT_EQ(half_edges.point_boundary, std::vector<uint8_t>(4, 0));
}

TEST(HalfEdge, a_cube_has_euler_characteristic_two) {
  const HalfEdges half_edges = build(cube());
  expect_no_defect(half_edges);
  EXPECT_EQ(half_edges.point_count, 8);
  EXPECT_EQ(euler_characteristic(half_edges), 2);
  EXPECT_EQ(half_edges.welded_vertices, 0);
}

TEST(HalfEdge, a_grid_has_a_boundary_around_it) {
  const HalfEdges half_edges = build(grid(3, 2));
  expect_no_defect(half_edges);
  EXPECT_EQ(half_edges.point_count, 12);
  EXPECT_EQ(half_edges.boundary_edges, 10);
  EXPECT_EQ(open_half_edges(half_edges), 10);
  EXPECT_EQ(euler_characteristic(half_edges), 1);
  for (int32_t vertex = 0; vertex < 12; ++vertex) {
    const bool is_inner = vertex == 5 || vertex == 6;
    EXPECT_EQ(half_edges.point_boundary[at(half_edges.vertex_point[at(vertex)])], !is_inner) << "vertex " << vertex;
  }
}

TEST(HalfEdge, a_cube_split_by_an_exporter_closes_again) {
  const Shape shape = split(cube());
  const HalfEdges half_edges = build(shape);
  expect_no_defect(half_edges);
  EXPECT_EQ(half_edges.point_count, 8);
  EXPECT_EQ(half_edges.boundary_edges, 0);
  EXPECT_EQ(half_edges.welded_vertices, 36 - 8);
  EXPECT_EQ(euler_characteristic(half_edges), 2);
  for (size_t a = 0; a < 36; ++a)
    for (size_t b = 0; b < 36; ++b)
      EXPECT_EQ(half_edges.vertex_point[a] == half_edges.vertex_point[b], shape.positions[a] == shape.positions[b]);
}

TEST(HalfEdge, a_cube_with_vertices_shared_within_each_side_closes_too) {
  Shape shape;
  const Shape whole = cube();
  for (size_t side = 0; side < 6; ++side) { // the two triangles of a side share vertices, sides do not: 24 vertices
    const auto begin = whole.faces.begin() + static_cast<std::ptrdiff_t>(6 * side);
    const Shape quad = share(split({whole.positions, {begin, begin + 6}}));
    shape = join(shape, quad);
  }
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.point_count, 8);
  EXPECT_EQ(half_edges.boundary_edges, 0);
  EXPECT_EQ(half_edges.nonmanifold_edges, 0);
  EXPECT_EQ(half_edges.welded_vertices, 24 - 8);
}

TEST(HalfEdge, closed_parts_that_touch_stay_apart) {
  const HalfEdges half_edges = build(join(cube(), cube({1, 1, 0}))); // along one edge, each with vertices of its own
  expect_no_defect(half_edges);
  EXPECT_EQ(half_edges.point_count, 16);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(half_edges.boundary_edges, 0);
  EXPECT_EQ(half_edges.welded_vertices, 0);
}

TEST(HalfEdge, closed_parts_that_touch_along_a_side_stay_apart) {
  const HalfEdges half_edges = build(join(cube(), cube({1, 0, 0})));
  expect_no_defect(half_edges);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(open_half_edges(half_edges), 0);
}

TEST(HalfEdge, cubes_that_share_an_edge_by_index_come_apart_and_close) {
  const HalfEdges half_edges = build(share(join(cube(), cube({1, 1, 0}))));
  EXPECT_EQ(half_edges.point_count, 16);
  EXPECT_EQ(half_edges.nonmanifold_edges, 1);
  EXPECT_EQ(half_edges.nonmanifold_vertices, 2);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(open_half_edges(half_edges), 0) << "each cube's two faces at the edge are paired with each other";
  EXPECT_EQ(half_edges.loose_vertices, 2) << "the second cube's own two vertices, which share() left without a face";
}

TEST(HalfEdge, split_cubes_that_share_an_edge_do_not_join) {
  const HalfEdges half_edges = build(split(join(cube(), cube({1, 1, 0}))));
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(half_edges.nonmanifold_edges, 1);
}

TEST(HalfEdge, a_bow_tie_vertex_becomes_two_points_and_the_wider_answers) {
  // A narrow triangle first, then two with a right angle each, all at vertex 0.
  const Shape shape = {{{0, 0, 0}, {-4, -1, 0}, {-4, -2, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 1}}, {0, 1, 2, 0, 3, 4, 0, 4, 5}};
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.point_count, 7);
  EXPECT_EQ(half_edges.nonmanifold_vertices, 1);
  EXPECT_EQ(half_edges.nonmanifold_edges, 0);
  EXPECT_EQ(half_edges.boundary_edges, 7);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_NE(half_edges.corner_point[0], half_edges.corner_point[3]);
  EXPECT_EQ(half_edges.corner_point[3], half_edges.corner_point[6]);
  EXPECT_EQ(half_edges.vertex_point[0], half_edges.corner_point[3]);
}

TEST(HalfEdge, of_equally_wide_fans_the_first_point_answers) {
  const Shape shape = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {0, 1, 2, 0, 3, 4}};
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.nonmanifold_vertices, 1);
  EXPECT_EQ(half_edges.vertex_point[0], std::min(half_edges.corner_point[0], half_edges.corner_point[3]));
}

TEST(HalfEdge, three_faces_on_an_edge_are_taken_apart) {
  const Shape shape = {{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}}, {0, 1, 2, 0, 1, 3, 1, 0, 4}};
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.nonmanifold_edges, 1);
  EXPECT_EQ(half_edges.opposed_edges, 0);
  EXPECT_EQ(half_edges.nonmanifold_vertices, 2);
  EXPECT_EQ(half_edges.boundary_edges, 6);
  EXPECT_EQ(half_edges.point_count, 9);
  EXPECT_EQ(half_edges.components, 3);
}

TEST(HalfEdge, a_neighbor_wound_the_other_way_is_taken_off) {
  const Shape shape = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0, 1, 2, 0, 3, 2}};
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.nonmanifold_edges, 1);
  EXPECT_EQ(half_edges.opposed_edges, 1);
  EXPECT_EQ(half_edges.boundary_edges, 4);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(half_edges.point_count, 6);
}

TEST(HalfEdge, a_flipped_face_of_a_closed_mesh_comes_off_alone) {
  Shape shape = cube();
  std::swap(shape.faces[0], shape.faces[1]);
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.nonmanifold_edges, 3);
  EXPECT_EQ(half_edges.boundary_edges, 0);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(half_edges.point_count, 8 + 3);
}

TEST(HalfEdge, triangles_without_area_are_left_out) {
  Shape shape = tetrahedron();
  shape.positions.insert(shape.positions.end(), {{0.5f, 0, 0}, {0, 0, 0}, {2, 2, 2}});
  shape.faces.insert(shape.faces.end(), {0, 1, 4}); // collinear
  shape.faces.insert(shape.faces.end(), {1, 1, 2}); // a vertex twice
  shape.faces.insert(shape.faces.end(), {0, 5, 2}); // a position twice
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.degenerate_triangles, 3);
  EXPECT_EQ(half_edges.nonmanifold_edges, 0) << "what is left out takes no edge from others";
  EXPECT_EQ(half_edges.point_count, 4);
  EXPECT_EQ(open_half_edges(half_edges), 0);
  for (size_t corner = 12; corner < 21; ++corner) EXPECT_EQ(half_edges.corner_point[corner], -1);
  EXPECT_EQ(half_edges.loose_vertices, 2);
  EXPECT_EQ(half_edges.vertex_point[4], -1);
  EXPECT_EQ(half_edges.vertex_point[5], half_edges.vertex_point[0]) << "its place has a point";
}

TEST(HalfEdge, slivers_far_from_the_origin_stay) {
  const Shape shape = {{{1000, 1000, 0}, {1001, 1000, 0}, {1000.5f, 1000.0001f, 0}}, {0, 1, 2}};
  EXPECT_EQ(build(shape).degenerate_triangles, 0);
}

TEST(HalfEdge, a_mesh_of_nothing_but_degenerate_triangles_has_no_points) {
  const HalfEdges half_edges = build({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {0, 1, 2, 0, 0, 1}});
  EXPECT_EQ(half_edges.degenerate_triangles, 2);
  EXPECT_EQ(half_edges.point_count, 0);
  EXPECT_EQ(half_edges.components, 0);
  EXPECT_EQ(half_edges.loose_vertices, 3);
}

TEST(HalfEdge, a_moebius_strip_is_cut_once_across) {
  constexpr int quads = 8;
  Shape shape;
  for (int i = 0; i < quads; ++i)
    for (int side = -1; side <= 1; side += 2) {
      const double turn = 2 * pi * i / quads, twist = turn / 2;
      const double radius = 2 + 0.5 * side * std::cos(twist);
      shape.positions.push_back(vec3(radius * std::cos(turn), radius * std::sin(turn), 0.5 * side * std::sin(twist)));
    }
  for (int32_t i = 0; i < quads; ++i) {
    const int32_t a = 2 * i, b = a + 1;
    const bool last = i == quads - 1; // the sides change places
    const int32_t c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    shape.faces.insert(shape.faces.end(), {a, b, d, a, d, c});
  }
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.nonmanifold_edges, 1);
  EXPECT_EQ(half_edges.boundary_edges, 2 * quads);
  EXPECT_EQ(half_edges.components, 1);
  EXPECT_EQ(half_edges.point_count, 2 * quads + 2) << "the ends of the cut edge are there twice";
  EXPECT_EQ(euler_characteristic(half_edges), 1);
}

TEST(HalfEdge, vertices_without_a_face_are_loose) {
  Shape shape = tetrahedron();
  shape.positions.push_back(vec3(5));
  shape.positions.push_back(vec3(0)); // even where it lies on the mesh
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.loose_vertices, 2);
  EXPECT_EQ(half_edges.vertex_point[4], -1);
  EXPECT_EQ(half_edges.vertex_point[5], -1);
  EXPECT_EQ(half_edges.welded_vertices, 0);
}

TEST(HalfEdge, the_order_of_faces_and_corners_does_not_matter) {
  Shape shape = join(grid(30, 20), cube({40, 0, 0}));
  std::mt19937 random(7);
  std::vector<std::array<int32_t, 3>> faces;
  for (size_t i = 0; i < shape.faces.size(); i += 3) faces.push_back({shape.faces[i], shape.faces[i + 1], shape.faces[i + 2]});
  for (int round = 0; round < 20; ++round) {
    for (size_t i = faces.size() - 1; i > 0; --i) std::swap(faces[i], faces[random() % (i + 1)]);
    shape.faces.clear();
    for (auto &face : faces) {
      std::rotate(face.begin(), face.begin() + static_cast<int>(random() % 3), face.end());
      shape.faces.insert(shape.faces.end(), face.begin(), face.end());
    }
    for (const Shape &variant : {shape, split(shape)}) {
      const HalfEdges half_edges = build(variant);
      expect_no_defect(half_edges);
      EXPECT_EQ(half_edges.point_count, 31 * 21 + 8);
      EXPECT_EQ(half_edges.boundary_edges, 100);
      EXPECT_EQ(half_edges.components, 2);
    }
  }
}

TEST(HalfEdge, random_triangles_on_few_positions_become_manifold) {
  for (unsigned seed = 0; seed < 2000; ++seed) { // build() checks every result
    std::mt19937 random(seed);
    Shape shape;
    const size_t vertices = 4 + random() % 8;
    for (size_t i = 0; i < vertices; ++i) shape.positions.push_back(vec3(random() % 3, random() % 3, random() % 3));
    const size_t corners = 3 * (1 + random() % 30);
    for (size_t i = 0; i < corners; ++i) shape.faces.push_back(static_cast<int32_t>(random() % vertices));
    const HalfEdges half_edges = build(seed % 2 ? split(shape) : shape);
    EXPECT_LE(half_edges.boundary_edges, open_half_edges(half_edges));
    if (testing::Test::HasFailure()) FAIL() << "seed " << seed;
  }
}

// Between the points b and c there would be two edges: one by index, of faces 0 and 1, and one of face 3 alone, which belongs to
// the tetrahedron of face 1 and its neighbors by place. OpenMesh knows one edge between two points.
Shape two_edges_between_two_points() {
  const vec3 a(0, 0, 1), b(0, 1, 0), c(1, 0, 1), d(1, 0, 0), x(1, 1, 1);
  return {{a, b, c, d, c, d, x}, {0, 1, 2, 2, 1, 3, 4, 5, 6, 4, 6, 1, 5, 1, 6}};
}

TEST(HalfEdge, a_face_that_openmesh_refuses_comes_off_but_is_not_lost) {
  const HalfEdges half_edges = build(two_edges_between_two_points());
  EXPECT_EQ(half_edges.degenerate_triangles, 0);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(half_edges.point_count, 5 + 3);
  EXPECT_EQ(half_edges.nonmanifold_edges, 2) << "those over which it had neighbors";
  EXPECT_EQ(half_edges.boundary_edges, 3);
  for (int32_t point : half_edges.corner_point) EXPECT_GE(point, 0);
}

TEST(HalfEdge, says_nothing_on_the_standard_streams) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  build(two_edges_between_two_points()); // OpenMesh would tell
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

} // namespace
} // namespace paradesc::test
