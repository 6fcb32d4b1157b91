// Half-edges of sound, split, touching and non-manifold meshes.
#include "mesh/halfedge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

namespace paradesc {
namespace {

struct Shape {
  std::vector<vec3> positions;
  std::vector<int32_t> faces; // three vertices each
};

Triangles triangles_of(const Shape &shape) {
  Triangles triangles;
  triangles.vertex_count = static_cast<int>(shape.positions.size());
  triangles.triangle_count = static_cast<int>(shape.faces.size() / 3);
  triangles.positions = shape.positions;
  triangles.corner_vertex = shape.faces;
  triangles.half_edge_sharp.assign(shape.faces.size(), 0);
  return triangles;
}

Shape tetrahedron() { return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}}; }

// Vertex i lies at its bits: x = i & 1, y = i >> 1 & 1, z = i >> 2.
Shape cube(vec3 offset = vec3(0)) {
  Shape shape;
  for (int i = 0; i < 8; ++i) shape.positions.push_back(vec3(i & 1, i >> 1 & 1, i >> 2) + offset);
  const int32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto &q : quads) shape.faces.insert(shape.faces.end(), {q[0], q[1], q[2], q[0], q[2], q[3]});
  return shape;
}

Shape grid(int width, int height) {
  Shape shape;
  for (int y = 0; y <= height; ++y)
    for (int x = 0; x <= width; ++x) shape.positions.push_back(vec3(x, y, 0.1f * static_cast<float>(x * y)));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int32_t a = y * (width + 1) + x, b = a + 1, c = b + width + 1, d = a + width + 1;
      shape.faces.insert(shape.faces.end(), {a, b, c, a, c, d});
    }
  return shape;
}

// Every corner gets a vertex of its own, as exporters do where normals or UVs differ.
Shape split(const Shape &shape) {
  Shape result;
  for (int32_t vertex : shape.faces) {
    result.faces.push_back(static_cast<int32_t>(result.positions.size()));
    result.positions.push_back(shape.positions[static_cast<size_t>(vertex)]);
  }
  return result;
}

Shape join(const Shape &a, const Shape &b) {
  Shape result = a;
  result.positions.insert(result.positions.end(), b.positions.begin(), b.positions.end());
  for (int32_t vertex : b.faces) result.faces.push_back(vertex + static_cast<int32_t>(a.positions.size()));
  return result;
}

// Equal positions become one vertex: what was split or apart shares indices.
Shape share(const Shape &shape) {
  Shape result = shape;
  for (int32_t &vertex : result.faces) {
    const vec3 p = shape.positions[static_cast<size_t>(vertex)];
    vertex = static_cast<int32_t>(std::find(shape.positions.begin(), shape.positions.end(), p) - shape.positions.begin());
  }
  return result;
}

size_t at(int32_t index) { return static_cast<size_t>(index); }

// Expects edges as OpenMesh has them: between two points there is one half-edge each way, and they are twins.
void expect_one_edge_between_two_points(const HalfEdges &half_edges) {
  std::map<std::pair<int32_t, int32_t>, int32_t> half_edge_of;
  for (int h = 0; h < static_cast<int>(half_edges.twin.size()); ++h) {
    const int32_t from = half_edges.corner_point[at(h)], to = half_edges.corner_point[at(next_corner(h))];
    if (from < 0) continue;
    EXPECT_TRUE(half_edge_of.emplace(std::pair(from, to), h).second) << "a second one from " << from << " to " << to;
    const auto other = half_edge_of.find({to, from});
    if (other == half_edge_of.end()) continue;
    EXPECT_EQ(half_edges.twin[at(h)], other->second);
  }
}

// Expects what holds for every mesh: twins are mutual and meet end to end, and turning about a point reaches all of its faces.
void expect_sound(const Triangles &triangles, const HalfEdges &half_edges) {
  std::vector<int> faces_at(at(half_edges.point_count), 0);
  for (int h = 0; h < 3 * triangles.triangle_count; ++h) {
    const int32_t twin = half_edges.twin[at(h)];
    const int32_t point = half_edges.corner_point[at(h)];
    if (point >= 0) ++faces_at[at(point)];
    if (twin < 0) continue;
    ASSERT_EQ(half_edges.twin[at(twin)], h);
    EXPECT_EQ(half_edges.corner_point[at(twin)], half_edges.corner_point[at(next_corner(h))]);
    EXPECT_EQ(half_edges.corner_point[at(next_corner(twin))], point);
  }
  for (int point = 0; point < half_edges.point_count; ++point) {
    const int32_t first = half_edges.point_half_edge[at(point)];
    int32_t h = first;
    int reached = 0;
    do {
      ASSERT_EQ(half_edges.corner_point[at(h)], point);
      ++reached;
      h = half_edges.twin[at(previous_corner(h))];
    } while (h >= 0 && h != first);
    EXPECT_EQ(reached, faces_at[at(point)]) << "faces reached about point " << point;
    EXPECT_EQ(half_edges.point_boundary[at(point)], h < 0);
    const int32_t vertex = half_edges.point_vertex[at(point)];
    EXPECT_EQ(triangles.positions[at(vertex)], triangles.positions[at(triangles.corner_vertex[at(first)])]);
  }
}

HalfEdges build(const Shape &shape) {
  const Triangles triangles = triangles_of(shape);
  const HalfEdges half_edges = build_half_edges(triangles);
  EXPECT_EQ(half_edges.twin.size(), shape.faces.size());
  EXPECT_EQ(half_edges.vertex_point.size(), shape.positions.size());
  expect_sound(triangles, half_edges);
  expect_one_edge_between_two_points(half_edges);
  return half_edges;
}

int open_half_edges(const HalfEdges &half_edges) {
  int count = 0;
  for (size_t h = 0; h < half_edges.twin.size(); ++h) count += half_edges.twin[h] < 0 && half_edges.corner_point[h] >= 0;
  return count;
}

void expect_no_defect(const HalfEdges &half_edges) {
  EXPECT_EQ(half_edges.degenerate_triangles, 0);
  EXPECT_EQ(half_edges.nonmanifold_edges, 0);
  EXPECT_EQ(half_edges.nonmanifold_vertices, 0);
  EXPECT_EQ(half_edges.loose_vertices, 0);
}

// Points - edges + faces of a mesh in which no triangle was left out.
int euler_characteristic(const HalfEdges &half_edges) {
  const int open = open_half_edges(half_edges);
  const int half_edge_count = static_cast<int>(half_edges.twin.size());
  return half_edges.point_count - (half_edge_count + open) / 2 + half_edge_count / 3;
}

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

TEST(HalfEdge, minus_zero_is_zero) {
  Shape shape = split(cube());
  for (size_t i = 0; i < shape.positions.size(); i += 2)
    for (int axis = 0; axis < 3; ++axis)
      if (shape.positions[i][axis] == 0) shape.positions[i][axis] = -0.0f;
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.point_count, 8);
  EXPECT_EQ(half_edges.boundary_edges, 0);
}

TEST(HalfEdge, positions_that_differ_in_the_last_bit_do_not_meet) {
  Shape shape = split(grid(1, 1)); // the diagonal runs from (0, 0) to (1, 1)
  shape.positions[3].x = std::nextafter(shape.positions[3].x, 1.0f);
  EXPECT_EQ(build(shape).boundary_edges, 6);
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
  EXPECT_EQ(half_edges.nonmanifold_vertices, 2);
  EXPECT_EQ(half_edges.boundary_edges, 6);
  EXPECT_EQ(half_edges.point_count, 9);
  EXPECT_EQ(half_edges.components, 3);
}

TEST(HalfEdge, a_neighbor_wound_the_other_way_is_taken_off) {
  const Shape shape = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0, 1, 2, 0, 3, 2}};
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.nonmanifold_edges, 1);
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

TEST(HalfEdge, a_duplicate_triangle_is_kept_and_taken_apart) {
  Shape shape = tetrahedron();
  shape.faces.insert(shape.faces.end(), {0, 2, 1});
  const HalfEdges half_edges = build(shape);
  EXPECT_EQ(half_edges.degenerate_triangles, 0);
  EXPECT_EQ(half_edges.nonmanifold_edges, 3);
  EXPECT_EQ(half_edges.components, 3) << "the other three faces, and each of the two";
  EXPECT_EQ(half_edges.loose_vertices, 0);
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
  EXPECT_EQ(half_edges.loose_vertices, 3);
  EXPECT_EQ(half_edges.vertex_point[4], -1);
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

TEST(HalfEdge, two_sides_of_one_triangle_close_over_its_rim) {
  const HalfEdges half_edges = build({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2, 0, 2, 1}});
  expect_no_defect(half_edges);
  EXPECT_EQ(half_edges.point_count, 3);
  EXPECT_EQ(half_edges.boundary_edges, 0);
  EXPECT_EQ(euler_characteristic(half_edges), 2);
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

// Between the points b and c there would be two edges, one by index (faces 0 and 2) and one of face 1 alone, which reaches c
// over d. OpenMesh knows one edge between two points.
Shape two_edges_between_two_points() {
  const vec3 a(0, 0, 1), b(0, 1, 0), c(1, 0, 1), d(1, 0, 0);
  return {{a, b, c, d, c, d}, {0, 1, 2, 4, 5, 1, 2, 1, 3}};
}

TEST(HalfEdge, a_face_that_openmesh_refuses_comes_off_but_is_not_lost) {
  const HalfEdges half_edges = build(two_edges_between_two_points());
  EXPECT_EQ(half_edges.degenerate_triangles, 0);
  EXPECT_EQ(half_edges.components, 2);
  EXPECT_EQ(half_edges.point_count, 4 + 3);
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
} // namespace paradesc
