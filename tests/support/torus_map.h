// H on a torus as a map f with closed forms: it depends on the angle v around the tube alone.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "support/surfaces.h"

namespace paradesc::test {

struct TorusMap {
  double major, minor;
  TestMesh mesh;
  std::vector<double> slope;     // (vertex_count) |grad H|
  std::vector<double> laplacian; // (vertex_count) Laplace-Beltrami of H
};

// H = (1/r + cos v/w)/2 with w = R + r cos v; d/ds = d/dv/r, and Laplace-Beltrami is (w H')'/(w r^2).
inline TorusMap torus_map(double major, double minor, const Triangulation &triangulation) {
  TorusMap map{major, minor, torus(major, minor, triangulation), {}, {}};
  for (const Vec3 parameter : map.mesh.parameters) {
    const double v = 2 * std::numbers::pi * parameter.y, w = major + minor * std::cos(v);
    map.slope.push_back(major * std::abs(std::sin(v)) / (2 * minor * w * w));
    map.laplacian.push_back(-major * (major * std::cos(v) + minor) / (2 * minor * minor * w * w * w));
  }
  return map;
}

inline double largest(const std::vector<double> &values) {
  double result = 0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
}

} // namespace paradesc::test
