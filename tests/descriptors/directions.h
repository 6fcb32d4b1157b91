// Principal directions → their mean angle to exact ones; the exact ones of a torus and of an ellipsoid.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "support/surfaces.h"

namespace paradesc::test {

// Mean angle to the exact directions, weighted by |k1 - k2|, in degrees; every value is checked to be a unit tangent with its
// largest component positive.
inline double mean_angle_to(std::span<const Vec3> exact, const TestMesh &mesh, std::span<const float> values) {
  double sum = 0, total = 0;
  for (size_t v = 0; v < exact.size(); ++v) {
    const Vec3 found{values[3 * v], values[3 * v + 1], values[3 * v + 2]};
    EXPECT_NEAR(length(found), 1, 1e-5) << "vertex " << v;
    EXPECT_NEAR(dot(found, mesh.normals[v]), 0, 1e-3) << "vertex " << v; // the fitted normals' error
    const double low = std::min({found.x, found.y, found.z}), high = std::max({found.x, found.y, found.z});
    EXPECT_GE(high, -low) << "vertex " << v;
    const double weight = std::sqrt(std::max(mesh.H[v] * mesh.H[v] - mesh.K[v], 0.0));
    sum += weight * std::acos(std::min(std::abs(dot(found, exact[v])), 1.0)) * 57.29577951308232;
    total += weight;
  }
  return sum / total;
}

struct Directions {
  std::vector<Vec3> largest, smallest; // of k1 and of k2, (vertex_count)
};

inline Directions directions_of_torus(const TestMesh &mesh) {
  Directions exact;
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 around = normalized({-mesh.points[v].y, mesh.points[v].x, 0});
    exact.largest.push_back(cross(mesh.normals[v], around));
    exact.smallest.push_back(around);
  }
  return exact;
}

// In the principal directions n turns by k times the way, so that the other direction's derivative of n is perpendicular. dn/dx
// is taken from the gradient of x^2/a^2 + y^2/b^2 + z^2/c^2.
inline Directions directions_of_ellipsoid(const TestMesh &mesh, double a, double b, double c) {
  Directions exact;
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 n = mesh.normals[v], p = mesh.points[v];
    const Vec3 t = normalized(std::abs(n.x) < 0.6 ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0})), s = cross(n, t);
    const double gradient = length({p.x / (a * a), p.y / (b * b), p.z / (c * c)});
    const auto form = [&](Vec3 u, Vec3 w) {
      return (u.x * w.x / (a * a) + u.y * w.y / (b * b) + u.z * w.z / (c * c)) / gradient;
    };
    const double angle = 0.5 * std::atan2(2 * form(t, s), form(t, t) - form(s, s));
    exact.largest.push_back(std::cos(angle) * t + std::sin(angle) * s);
    exact.smallest.push_back(cross(n, exact.largest.back()));
  }
  return exact;
}

} // namespace paradesc::test
