// Integrals of curvature's kernels over flat pieces of a surface, within a ball around the origin.
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "mesh/quadrature.h"
#include "support/math.h"

namespace paradesc {

// Of a plane, within the ball: around the foot of the origin, where the plane's coordinates start. It lies to the left of its
// segments; what else bounds it are arcs of the ball's rim, of which only their angles count.
struct CutRegion {
  double radius = 0; // of the rim
  double arcs = 0;   // the sum of their angles
  std::vector<std::pair<dvec2, dvec2>> segments;
};

// Of a triangle whose corners are counter-clockwise.
void cut_triangle(const std::array<dvec2, 3> &corners, double radius, CutRegion &region);

// Seen from the origin.
double solid_angle_of_triangle(const std::array<dvec3, 3> &corners);

// Integral of |h| (1/rho^3 - 1/r^3) over a region of a plane at the height |h| = height.
double seen_and_filled(const CutRegion &region, double height, double radius);

// visit(begin, end) of steps along a line from s to t that are short against their distance from the origin, which is `nearest`
// where s is 0.
template <class Visit> void visit_steps(double s, double t, double nearest, const Visit &visit) {
  constexpr double first = 2, factor = 4, last = 1.5;
  const auto outwards = [&](double from, double to, double sign) {
    for (double begin = from, end = 0; begin < to; begin = end) {
      end = std::max(first * nearest, factor * begin);
      if (last * end > to) end = to;
      visit(sign * begin, sign * end);
    }
  };
  if (t - s < nearest) return visit(s, t);
  outwards(std::max(-t, 0.0), -s, -1);
  outwards(std::max(s, 0.0), t, 1);
}

GaussRule step_rule(double s, double t, double nearest2); // for the kernel over such a step

// Of the radius: what changes nearer than that is next to nothing.
inline constexpr double least_distance = 1e-3;

// The kernel of H for what bends little, of a squared distance: its Laplacian is 1 - pi r^2 delta, and it vanishes at r with its
// slope.
double kernel_at(double rho2, double radius);
// The same within the ball, and its product with the distance, added up to there.
struct KernelValues {
  double at, up_to;
};
KernelValues kernel_values(double rho2, double radius);
double kernel_on_segment(dvec3 begin, dvec3 end, double radius);
double kernel_over(const CutRegion &region, double height, double radius);

} // namespace paradesc
