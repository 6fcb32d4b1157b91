// Integrals of curvature's kernels over planar pieces of a surface, within a ball around the origin.
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "mesh/quadrature.h"
#include "support/math.h"

namespace paradesc {

// The part of a planar region within the ball. Coordinates are relative to the foot of the origin on the plane. The region lies
// to the left of its segments. The rest of its boundary consists of arcs of the ball's rim, of which only the angles matter.
struct CutRegion {
  double radius = 0; // of the rim
  double arcs = 0;   // the sum of their angles
  std::vector<std::pair<dvec2, dvec2>> segments;
};

// Cuts a triangle whose corners are counter-clockwise.
void cut_triangle(const std::array<dvec2, 3> &corners, double radius, CutRegion &region);

// Returns the integral of |h| (1/rho^3 - 1/r^3) over a region of a plane at the height |h| = height.
double seen_and_filled(const CutRegion &region, double height, double radius);

// Calls visit(begin, end) for steps along a line from s to t that are short compared with their distance from the origin, which
// is `nearest` at s = 0.
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

// Kernels change negligibly below this distance, which is relative to the radius.
inline constexpr double least_distance = 1e-3;

// Returns the kernel of H for surfaces that bend little, at a squared distance. Its Laplacian is 1 - pi r^2 delta. The kernel and
// its slope vanish at r.
double kernel_at(double rho2, double radius);
// The kernel at a distance within the ball, and the integral of kernel times distance up to there.
struct KernelValues {
  double at, up_to;
};
KernelValues kernel_values(double rho2, double radius);
double kernel_on_segment(dvec3 begin, dvec3 end, double radius);
double kernel_over(const CutRegion &region, double height, double radius);

} // namespace paradesc
