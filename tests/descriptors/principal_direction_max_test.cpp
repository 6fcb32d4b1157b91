// The direction of k1.
#include "support/run.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include "support/layout.h"

namespace paradesc::test {
namespace {

class PrincipalDirectionMax : public OnBackend {
protected:
  // Mean angle to the exact directions, weighted by |k1 - k2|, in degrees; every value is checked to be a unit tangent with its
  // largest component positive.
  double mean_angle(const TestMesh &mesh, std::span<const float> values, std::span<const Vec3> exact) {
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
};
PDESC_ON_EACH_BACKEND(PrincipalDirectionMax);

// Issue "All of the paper": a mean angle of 1 degree at most.
TEST_P(PrincipalDirectionMax, torus_has_it_around_the_tube) {
  TestMesh mesh = torus(1, 0.4);
  lay_out(mesh, {.charts = 15});
  std::vector<Vec3> exact;
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 around = normalized({-mesh.points[v].y, mesh.points[v].x, 0});
    exact.push_back(cross(mesh.normals[v], around));
  }
  const double angle = mean_angle(mesh, compute_one(mesh, "principal_direction_max", {}), exact);
  std::cout << "mean angle " << angle << " degrees\n";
  EXPECT_LE(angle, 1);
}

// Of an ellipsoid the principal directions are those of the confocal quadrics: in them n turns by k times the way, so that
// the other direction's derivative of n is perpendicular. dn/dx is taken from the gradient of x^2/a^2 + y^2/b^2 + z^2/c^2.
TEST_P(PrincipalDirectionMax, ellipsoid_has_it_where_the_derivative_of_the_normal_is_largest) {
  const double a = 1, b = 0.75, c = 0.5;
  TestMesh mesh = ellipsoid(a, b, c);
  lay_out(mesh, {.charts = 15});
  std::vector<Vec3> exact;
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 n = mesh.normals[v], p = mesh.points[v];
    const Vec3 t = normalized(std::abs(n.x) < 0.6 ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0})), s = cross(n, t);
    const double gradient = length({p.x / (a * a), p.y / (b * b), p.z / (c * c)});
    const auto form = [&](Vec3 u, Vec3 w) {
      return (u.x * w.x / (a * a) + u.y * w.y / (b * b) + u.z * w.z / (c * c)) / gradient;
    };
    const double angle = 0.5 * std::atan2(2 * form(t, s), form(t, t) - form(s, s));
    const Vec3 largest = std::cos(angle) * t + std::sin(angle) * s;
    exact.push_back(largest);
  }
  const double angle = mean_angle(mesh, compute_one(mesh, "principal_direction_max", {}), exact);
  std::cout << "mean angle " << angle << " degrees\n";
  EXPECT_LE(angle, 1);
}

} // namespace
} // namespace paradesc::test
