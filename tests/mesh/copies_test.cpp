// Copies of faces leave a surface as it is without them.
#include "mesh/copies.h"

#include <algorithm>
#include <array>
#include <random>

#include <gtest/gtest.h>

#include "support/triangle_lists.h"

namespace paradesc::test {
namespace {

using namespace shapes;

// The faces of a shape again, each turned on by a corner, and turned over if asked for.
std::vector<int32_t> again(const Shape &shape, bool over) {
  std::vector<int32_t> faces;
  for (size_t i = 0; i < shape.faces.size(); i += 3) {
    std::array<int32_t, 3> face = {shape.faces[i + 1], shape.faces[i + 2], shape.faces[i]};
    if (over) std::swap(face[0], face[1]);
    faces.insert(faces.end(), face.begin(), face.end());
  }
  return faces;
}

Shape with_copies(Shape shape, bool over) {
  const std::vector<int32_t> faces = again(shape, over);
  shape.faces.insert(shape.faces.end(), faces.begin(), faces.end());
  return shape;
}

// Expects of copies that follow a surface that it is as it is without them.
void expect_as_without_copies(const Shape &surface, const Shape &doubled) {
  const HalfEdges alone = build(surface), half_edges = build(doubled);
  EXPECT_EQ(half_edges.copied_triangles, static_cast<int>((doubled.faces.size() - surface.faces.size()) / 3));
  EXPECT_EQ(half_edges.nonmanifold_edges, alone.nonmanifold_edges);
  EXPECT_EQ(half_edges.nonmanifold_vertices, alone.nonmanifold_vertices);
  EXPECT_EQ(half_edges.boundary_edges, alone.boundary_edges);
  EXPECT_EQ(half_edges.components, alone.components);
  EXPECT_EQ(half_edges.loose_vertices, alone.loose_vertices);
  ASSERT_EQ(half_edges.point_count, alone.point_count);
  for (size_t corner = 0; corner < surface.faces.size(); ++corner) {
    EXPECT_EQ(half_edges.twin[corner], alone.twin[corner]);
    EXPECT_EQ(half_edges.corner_point[corner], alone.corner_point[corner]);
  }
  for (size_t vertex = 0; vertex < surface.positions.size(); ++vertex)
    EXPECT_EQ(half_edges.vertex_point[vertex], alone.vertex_point[vertex]);
  for (size_t vertex = surface.positions.size(); vertex < doubled.positions.size(); ++vertex) { // at places of the surface
    const int32_t point = half_edges.vertex_point[vertex];
    ASSERT_GE(point, 0);
    EXPECT_EQ(doubled.positions[vertex], doubled.positions[at(half_edges.point_vertex[at(point)])]);
  }
}

TEST(Copies, copies_of_faces_count_once) {
  for (const Shape &surface : {tetrahedron(), cube(), grid(4, 3), grid(1, 1)})
    for (const bool over : {false, true}) {
      expect_as_without_copies(surface, with_copies(surface, over));
      Shape triple = with_copies(surface, over);
      const std::vector<int32_t> more = again(surface, !over);
      triple.faces.insert(triple.faces.end(), more.begin(), more.end());
      expect_as_without_copies(surface, triple);
    }
}

TEST(Copies, copies_of_some_faces_count_once) {
  for (const Shape &surface : {cube(), grid(4, 3)})
    for (const bool over : {false, true})
      for (size_t first = 0; first + 15 <= surface.faces.size(); first += 3) {
        Shape partly = surface;
        const std::vector<int32_t> faces = again(surface, over);
        partly.faces.insert(partly.faces.end(), faces.begin() + static_cast<int>(first),
                            faces.begin() + static_cast<int>(first) + 15);
        expect_as_without_copies(surface, partly);
      }
}

TEST(Copies, a_few_copies_that_come_first_give_way_to_the_surface) {
  const Shape surface = grid(4, 3);
  for (const bool over : {false, true}) {
    Shape shape = surface;
    const std::vector<int32_t> faces = again(surface, over);
    shape.faces.insert(shape.faces.begin(), faces.begin() + 9, faces.begin() + 24);
    const HalfEdges half_edges = build(shape);
    EXPECT_EQ(half_edges.copied_triangles, 5);
    EXPECT_EQ(half_edges.components, 1);
    EXPECT_EQ(half_edges.nonmanifold_edges, 0);
    EXPECT_EQ(half_edges.boundary_edges, 14);
    if (over) {
      for (size_t corner = 0; corner < 15; ++corner)
        EXPECT_EQ(half_edges.corner_point[corner], -1) << "the others are wound alike";
    }
  }
}

TEST(Copies, copies_that_are_wound_alike_have_the_points_of_what_they_copy) {
  expect_as_without_copies(grid(4, 3), join(grid(4, 3), grid(4, 3)));
  expect_as_without_copies(split(cube()), join(split(cube()), split(cube())));
  expect_as_without_copies(grid(4, 3), join(grid(4, 3), grid(4, 1))); // a row of it
  Shape side = cube();
  side.positions.resize(4);
  side.faces.resize(6);
  expect_as_without_copies(cube(), join(cube(), side)); // no edge of the cube is open
}

TEST(Copies, the_sheet_that_is_kept_of_a_double_sided_one_is_wound_alike_in_any_order_of_faces) {
  const Shape doubled = with_copies(grid(6, 5), true);
  std::mt19937 random(5);
  std::vector<std::array<int32_t, 3>> faces;
  for (size_t i = 0; i < doubled.faces.size(); i += 3)
    faces.push_back({doubled.faces[i], doubled.faces[i + 1], doubled.faces[i + 2]});
  for (int round = 0; round < 20; ++round) {
    std::ranges::shuffle(faces, random);
    Shape shape = doubled;
    shape.faces.clear();
    for (const auto &face : faces) shape.faces.insert(shape.faces.end(), face.begin(), face.end());
    for (const Shape &variant : {shape, share(split(shape))}) {
      const HalfEdges half_edges = build(variant);
      EXPECT_EQ(half_edges.copied_triangles, 60);
      EXPECT_EQ(half_edges.components, 1);
      EXPECT_EQ(half_edges.boundary_edges, 22);
      EXPECT_EQ(half_edges.nonmanifold_edges, 0);
      EXPECT_EQ(half_edges.point_count, 42);
    }
  }
}

TEST(Copies, back_faces_with_vertices_of_their_own_are_a_sheet_of_their_own) {
  Shape back = grid(4, 3);
  back.faces = again(back, true);
  for (const Shape &shape : {join(grid(4, 3), back), split(with_copies(grid(4, 3), true))}) {
    const HalfEdges half_edges = build(shape);
    EXPECT_EQ(half_edges.copied_triangles, 0);
    EXPECT_EQ(half_edges.components, 2) << "the front is not joined with the back over the rim";
    EXPECT_EQ(half_edges.boundary_edges, 28);
    EXPECT_EQ(half_edges.nonmanifold_edges, 0);
    EXPECT_EQ(half_edges.nonmanifold_vertices, 0);
  }
}

TEST(Copies, the_front_answers_for_vertices_that_a_back_with_some_of_its_own_shares) {
  const Shape surface = grid(4, 3);
  Shape shape = with_copies(surface, true);
  const auto own = static_cast<int32_t>(shape.positions.size());
  shape.positions.push_back(shape.positions[7]);
  for (size_t corner = surface.faces.size(); corner < shape.faces.size(); ++corner)
    if (shape.faces[corner] == 7) shape.faces[corner] = own;
  const HalfEdges half_edges = build(shape), alone = build(surface);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(half_edges.nonmanifold_edges, 0);
  for (size_t vertex = 0; vertex < surface.positions.size(); ++vertex)
    EXPECT_EQ(half_edges.vertex_point[vertex], alone.vertex_point[vertex]);
  EXPECT_NE(half_edges.vertex_point[at(own)], half_edges.vertex_point[7]);
}

TEST(Copies, a_closed_mesh_with_a_face_at_the_places_of_another_ones_stays_closed) {
  // Two boxes on the same ground, and two side by side: faces are copies, wound alike and the other way.
  Shape higher = cube();
  for (vec3 &p : higher.positions) p.z *= 2;
  for (const Shape &shape : {join(cube(), higher), join(cube(), cube({1, 0, 0}))}) {
    const HalfEdges half_edges = build(shape);
    expect_no_defect(half_edges);
    EXPECT_EQ(half_edges.copied_triangles, 0);
    EXPECT_EQ(half_edges.components, 2);
    EXPECT_EQ(open_half_edges(half_edges), 0);
    const HalfEdges more = build(join(shape, with_copies(tetrahedron(), false))); // copies that are left out
    EXPECT_EQ(more.copied_triangles, 4);
    EXPECT_EQ(more.components, 3);
    EXPECT_EQ(more.boundary_edges, 0);
  }
}

TEST(Copies, two_sides_of_one_triangle_are_one_open_triangle) {
  const HalfEdges half_edges = build({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2, 0, 2, 1}});
  expect_no_defect(half_edges);
  EXPECT_EQ(half_edges.copied_triangles, 1);
  EXPECT_EQ(half_edges.point_count, 3);
  EXPECT_EQ(half_edges.boundary_edges, 3);
}

} // namespace
} // namespace paradesc::test
