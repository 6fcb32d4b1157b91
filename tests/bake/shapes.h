// Positions, faces and UVs → what the bake reads: triangles, half-edges, charts. Affine maps between a plane and its charts.
#pragma once

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "mesh/triangles.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {

inline size_t at(int32_t index) { return static_cast<size_t>(index); }

struct Shape {
  std::vector<vec3> positions;
  std::vector<int32_t> faces; // three vertices each
  std::vector<vec2> uvs;      // one for each of those
};

struct Built {
  Triangles triangles;
  HalfEdges half_edges;
  Charts charts;
  vec3 position(int corner) const { return triangles.positions[at(triangles.corner_vertex[at(corner)])]; }
  dvec2 uv(int corner) const { return dvec2(charts.corner_uv[at(corner)]); }
};

inline Built build(Triangles triangles) {
  Built built;
  built.triangles = std::move(triangles);
  built.half_edges = build_half_edges(built.triangles);
  built.charts = build_charts(built.triangles, built.half_edges);
  return built;
}

inline Built build(const Shape &shape) {
  Triangles triangles = test::shape(shape.positions, shape.faces);
  triangles.input_uv = triangles.corner_uv = shape.uvs;
  return build(std::move(triangles));
}

inline Built build(const TestMesh &mesh) {
  const pdesc_mesh_input input = input_of(mesh);
  return build(read_triangles(input));
}

// A grid of quads over [0, width] x [0, height] of the plane z = 0, unit cells. uv(position, quad x, quad y).
inline Shape grid(int width, int height, const std::function<dvec2(dvec2, int, int)> &uv) {
  Shape shape;
  for (int y = 0; y <= height; ++y)
    for (int x = 0; x <= width; ++x) shape.positions.push_back(vec3(x, y, 0));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int32_t a = y * (width + 1) + x, b = a + 1, c = b + width + 1, d = a + width + 1;
      for (const int32_t vertex : {a, b, c, a, c, d}) {
        shape.faces.push_back(vertex);
        shape.uvs.push_back(vec2(uv(dvec2(vec2(shape.positions[at(vertex)])), x, y)));
      }
    }
  return shape;
}

// (u, v) = origin + linear * position
struct Affine {
  dmat2 linear{1.0};
  dvec2 origin{0.0};
  dvec2 operator()(dvec2 position) const { return origin + linear * position; }
};

// The chart of each quad of a 4 by 3 grid on a chart of its own: turned, stretched and, every third, mirrored.
inline Affine chart_of_quad(int x, int y) {
  const int number = 4 * y + x;
  const double angle = 0.7 * number, stretch = 0.08 + 0.005 * (number % 5), other = (number % 3 == 2 ? -1.1 : 1.0) * stretch;
  const dmat2 linear = dmat2(std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle)) * dmat2(stretch, 0, 0, other);
  const dvec2 middle((x + 0.5) / 4, (y + 0.5) / 3);
  return {linear, middle - linear * dvec2(x + 0.5, y + 0.5)};
}
inline bool mirrored_quad(int number) { return number % 3 == 2; }

inline Built plane_of_twelve_charts() {
  return build(grid(4, 3, [](dvec2 position, int x, int y) { return chart_of_quad(x, y)(position); }));
}

} // namespace paradesc::test
