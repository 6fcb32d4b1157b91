// The oracle's quadrature over the part of a triangle in a disc, against subdivision and against sums that must come out.
#include "mesh/quadrature.h"

#include <array>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "support/surfaces.h"

namespace paradesc::test {
namespace {

using paradesc::cross; // in the plane, beside that of space

double region_area(const std::array<dvec2, 3> &corners, double radius) {
  double area = 0;
  const DiscRegion region = clip_by_disc(corners, radius);
  visit_region(region, nearest_to_origin(corners), gauss_rule(8), [&](dvec2, double weight) { area += weight; });
  return area;
}

using Integrand = double (*)(dvec2);
constexpr Integrand integrands[] = {[](dvec2) { return 1.0; }, [](dvec2 x) { return x.x * x.x + 0.3 * x.x * x.y; },
                                    [](dvec2 x) { return std::sqrt(0.25 + glm::dot(x, x)); },
                                    [](dvec2 x) { return 1 / (0.25 + glm::dot(x, x)); }};

std::array<dvec2, 3> random_triangle(Random &random) {
  std::array<dvec2, 3> corners;
  for (dvec2 &p : corners) p = {random.uniform(-2, 2), random.uniform(-2, 2)};
  if (cross(corners[1] - corners[0], corners[2] - corners[0]) < 0) std::swap(corners[1], corners[2]);
  return corners;
}

// Midpoints of n² equal parts, those outside of the disc left out.
double subdivide(const std::array<dvec2, 3> &corners, double radius, Integrand integrand) {
  constexpr int n = 600;
  const dvec2 u = (corners[1] - corners[0]) / double{n}, v = (corners[2] - corners[0]) / double{n};
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j)
      for (const double third : {1.0 / 3, 2.0 / 3}) {
        if (third > 0.5 && i + j == n - 1) continue;
        const dvec2 x = corners[0] + (i + third) * u + (j + third) * v;
        if (glm::dot(x, x) < radius * radius) sum += integrand(x);
      }
  return sum * cross(u, v) / 2;
}

TEST(ReferenceQuadrature, agrees_with_subdivision) {
  Random random(11);
  for (int k = 0; k < 60; ++k) {
    const std::array<dvec2, 3> corners = random_triangle(random);
    const double radius = random.uniform(0.2, 2);
    const DiscRegion region = clip_by_disc(corners, radius);
    for (const Integrand integrand : integrands) {
      double found = 0;
      visit_region(region, nearest_to_origin(corners), gauss_rule(12), [&](dvec2 x, double w) { found += w * integrand(x); });
      // Parts on the rim (some 4 of 600 rows' worth) count wholly or not: their signs are random, their values up to 4.
      const double area = cross(corners[1] - corners[0], corners[2] - corners[0]) / 2;
      EXPECT_NEAR(found, subdivide(corners, radius, integrand), 4 * area * 2e-4) << "case " << k;
    }
  }
}

TEST(ReferenceQuadrature, parts_of_a_triangle_sum_to_the_whole) {
  Random random(12);
  for (int k = 0; k < 20000; ++k) {
    const auto [a, b, c] = random_triangle(random);
    const double s = random.uniform(), t = random.uniform();
    const dvec2 m = (1 - s) * a + s * ((1 - t) * b + t * c);
    // Often the point that parts it lies on the circle, or just beside it.
    const double radius =
        k % 3 == 0 ? random.uniform(0.2, 2) : glm::length(m) * (k % 3 == 1 ? 1 : 1 + random.uniform(-1e-9, 1e-9));
    const double whole = region_area({a, b, c}, radius);
    EXPECT_NEAR(region_area({a, b, m}, radius) + region_area({b, c, m}, radius) + region_area({c, a, m}, radius), whole, 1e-11)
        << "case " << k; // rounding, where the circle all but touches an edge
  }
}

TEST(ReferenceQuadrature, triangles_around_the_disc_sum_to_the_disc) {
  Random random(13);
  for (int k = 0; k < 2000; ++k) {
    const double turn = random.uniform(0, 2 * pi), radius = random.uniform(0.1, 1);
    const int count = 3 + k % 7;
    // The common corner lies inside, on the circle, or so far out that the last triangle holds the whole disc.
    const dvec2 common = (k % 4 == 0 ? 0 : k % 4 == 1 ? radius : random.uniform(0, 2)) * dvec2(std::cos(k), std::sin(k));
    double sum = 0;
    for (int i = 0; i < count; ++i) {
      const auto rim = [&](int j) {
        return 9.0 * dvec2(std::cos(turn + 2 * pi * j / count), std::sin(turn + 2 * pi * j / count));
      };
      sum += region_area({common, rim(i), rim(i + 1)}, radius);
    }
    EXPECT_NEAR(sum, pi * radius * radius, 1e-11) << "case " << k; // rounding, as above
  }
}

// Squares of a grid, cut along one diagonal or the other: corners lie exactly on the circle, some with an edge between them.
TEST(ReferenceQuadrature, triangles_with_corners_on_the_circle_sum_to_the_disc) {
  constexpr int cells = 6;
  for (const double radius : {1.0, std::sqrt(2.0), std::sqrt(5.0), 5.0})
    for (const bool other : {false, true}) {
      double area = 0;
      for (int i = 0; i < 4 * cells * cells; ++i) {
        const dvec2 first(i % (2 * cells) - cells, i / (2 * cells) - cells), x(1, 0), y(0, 1);
        const dvec2 a = other ? first + x : first, b = a + (other ? y : x), c = b + (other ? -x : y), d = c - (b - a);
        area += region_area({a, b, c}, radius) + region_area({a, c, d}, radius);
      }
      EXPECT_NEAR(area, pi * radius * radius, 1e-9) << radius;
    }
}

TEST(ReferenceQuadrature, whole_disc_within_a_triangle) {
  EXPECT_NEAR(region_area({{{-5, -5}, {7, -5}, {-2, 9}}}, 0.5), pi * 0.25, 1e-12);
  EXPECT_EQ(region_area({{{5, 5}, {7, 5}, {6, 9}}}, 0.5), 0);
}

TEST(ReferenceQuadrature, edges_that_graze_the_circle_change_nothing) {
  for (const double off : {-1e-7, -1e-12, -1e-16, 0.0, 1e-16, 1e-12, 1e-7}) {
    EXPECT_NEAR(region_area({{{-5, -1 + off}, {7, -1 + off}, {-2, 9}}}, 1), pi, 1e-9)
        << off; // the disc inside; 1e-7 of overlap take 1e-10
    EXPECT_NEAR(region_area({{{-5, 1 + off}, {7, 1 + off}, {-2, 9}}}, 1), 0, 1e-9) << off; // and outside
  }
}

TEST(ReferenceQuadrature, tiny_and_thin_triangles_keep_their_area) {
  for (const double size : {1e-3, 1e-6, 1e-9}) {
    EXPECT_NEAR(region_area({{{0.1, 0.1}, {0.1 + size, 0.1}, {0.1, 0.1 + size}}}, 1) / (size * size), 0.5, 1e-6) << size;
    EXPECT_NEAR(region_area({{{-0.5, 0}, {0.5, 0}, {0, size}}}, 1) / size, 0.5, 1e-6) << size;
  }
}

} // namespace
} // namespace paradesc::test
