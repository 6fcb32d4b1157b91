// Small meshes as lists of triangles, and what holds of the half-edges of any mesh.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "mesh/halfedge.h"
#include "support/solids.h"

namespace paradesc::test::shapes {

struct Shape {
  std::vector<vec3> positions;
  std::vector<int32_t> faces; // three vertices each
};

inline Triangles triangles_of(const Shape &shape) { return test::shape(shape.positions, shape.faces); }

inline Shape tetrahedron() { return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}}; }

// Vertex i lies at its bits: x = i & 1, y = i >> 1 & 1, z = i >> 2.
inline Shape cube(vec3 offset = vec3(0)) {
  Shape shape;
  for (int i = 0; i < 8; ++i) shape.positions.push_back(vec3(i & 1, i >> 1 & 1, i >> 2) + offset);
  const int32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto &q : quads) shape.faces.insert(shape.faces.end(), {q[0], q[1], q[2], q[0], q[2], q[3]});
  return shape;
}

inline Shape grid(int width, int height) {
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
inline Shape split(const Shape &shape) {
  Shape result;
  for (int32_t vertex : shape.faces) {
    result.faces.push_back(static_cast<int32_t>(result.positions.size()));
    result.positions.push_back(shape.positions[static_cast<size_t>(vertex)]);
  }
  return result;
}

inline Shape join(const Shape &a, const Shape &b) {
  Shape result = a;
  result.positions.insert(result.positions.end(), b.positions.begin(), b.positions.end());
  for (int32_t vertex : b.faces) result.faces.push_back(vertex + static_cast<int32_t>(a.positions.size()));
  return result;
}

inline Shape turned_over(Shape shape) {
  for (size_t i = 0; i < shape.faces.size(); i += 3) std::swap(shape.faces[i], shape.faces[i + 1]);
  return shape;
}

// Equal positions become one vertex: what was split or apart shares indices.
inline Shape share(const Shape &shape) {
  Shape result = shape;
  for (int32_t &vertex : result.faces) {
    const vec3 p = shape.positions[static_cast<size_t>(vertex)];
    vertex = static_cast<int32_t>(std::find(shape.positions.begin(), shape.positions.end(), p) - shape.positions.begin());
  }
  return result;
}

inline size_t at(int32_t index) { return static_cast<size_t>(index); }

// Expects edges as OpenMesh has them: between two points there is one half-edge each way, and they are twins.
inline void expect_one_edge_between_two_points(const HalfEdges &half_edges) {
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
inline void expect_sound(const Triangles &triangles, const HalfEdges &half_edges) {
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
    const vec3 apart = triangles.positions[at(vertex)] - triangles.positions[at(triangles.corner_vertex[at(first)])];
    EXPECT_LE(glm::length(apart), 1e-5f) << "the positions of one point differ by rounding at most";
  }
}

inline HalfEdges build(const Shape &shape) {
  const Triangles triangles = triangles_of(shape);
  const HalfEdges half_edges = build_half_edges(triangles);
  EXPECT_EQ(half_edges.twin.size(), shape.faces.size());
  EXPECT_EQ(half_edges.vertex_point.size(), shape.positions.size());
  expect_sound(triangles, half_edges);
  expect_one_edge_between_two_points(half_edges);
  return half_edges;
}

inline int open_half_edges(const HalfEdges &half_edges) {
  int count = 0;
  for (size_t h = 0; h < half_edges.twin.size(); ++h) count += half_edges.twin[h] < 0 && half_edges.corner_point[h] >= 0;
  return count;
}

inline void expect_no_defect(const HalfEdges &half_edges) {
  EXPECT_EQ(half_edges.degenerate_triangles, 0);
  EXPECT_EQ(half_edges.nonmanifold_edges, 0);
  EXPECT_EQ(half_edges.nonmanifold_vertices, 0);
  EXPECT_EQ(half_edges.loose_vertices, 0);
}

// Points - edges + faces of a mesh in which no triangle was left out.
inline int euler_characteristic(const HalfEdges &half_edges) {
  const int open = open_half_edges(half_edges);
  const int half_edge_count = static_cast<int>(half_edges.twin.size());
  return half_edges.point_count - (half_edge_count + open) / 2 + half_edge_count / 3;
}

} // namespace paradesc::test::shapes
