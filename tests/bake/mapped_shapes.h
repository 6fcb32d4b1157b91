// Bases, the images that displace them, and what becomes of them.
#pragma once

#include <algorithm>

#include "bake/mapped.h"

namespace paradesc::test {

// ---- A plane with a spherical cap of 60 degrees

inline constexpr double cap_radius = 0.8, cap_top = cap_radius * 0.5, rim = 0.8 * 0.86602540378443865;

inline double cap_height(double x, double y) {
  const double square = x * x + y * y;
  return square < rim * rim ? std::sqrt(cap_radius * cap_radius - square) - cap_radius * 0.5 : 0.0;
}

// 2 x 2, its UV map the unit square.
inline TestMesh unwrapped_plane(int vertices) {
  TestMesh mesh = plane(2, 2, {.vertices = vertices});
  for (const int32_t vertex : mesh.corner_vertices) {
    mesh.corner_uvs.push_back(static_cast<float>(mesh.parameters[at(vertex)].x));
    mesh.corner_uvs.push_back(static_cast<float>(mesh.parameters[at(vertex)].y));
  }
  return mesh;
}

inline Maps cap_map(int size) {
  return displacement(
      size, size, [](double u, double v) { return 0.25 + cap_height(2 * u - 1, 2 * v - 1) / cap_top; }, 0.25, cap_top);
}

// The plane's vertices on the cap itself.
inline TestMesh cap_as_geometry(TestMesh mesh) {
  for (Vec3 &point : mesh.points) point.z = cap_height(point.x, point.y);
  round_to_float(mesh);
  return mesh;
}

inline std::vector<uint8_t> inside_the_cap(const TestMesh &mesh, double margin) {
  std::vector<uint8_t> inside;
  for (const Vec3 &point : mesh.points) inside.push_back(std::hypot(point.x, point.y) < rim - margin);
  return inside;
}

// ---- A torus with waves

inline double wave(double u, double v) { return 0.5 + 0.5 * std::cos(6 * pi * u) * std::sin(4 * pi * v); }

// Its UV map are its parameters; triangles over the end of a period go beyond 1, where the image repeats.
inline TestMesh unwrapped_torus(int vertices) {
  TestMesh mesh = torus(1, 0.4, {.vertices = vertices});
  for (size_t triangle = 0; triangle < mesh.corner_vertices.size(); triangle += 3)
    for (size_t i = 0; i < 3; ++i)
      for (int axis = 0; axis < 2; ++axis) {
        auto value = [&](size_t corner) { return mesh.parameters[at(mesh.corner_vertices[triangle + corner])][axis]; };
        const double highest = std::max({value(0), value(1), value(2)});
        mesh.corner_uvs.push_back(static_cast<float>(value(i) + (highest - value(i) > 0.5 ? 1 : 0)));
      }
  return mesh;
}

} // namespace paradesc::test
