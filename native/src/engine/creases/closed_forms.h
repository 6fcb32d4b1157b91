// Integrals of curvature's kernels over planar pieces of a surface, within a ball around the origin.
#pragma once

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

// These return the integral of the kernel of H for surfaces that bend little, (rho^2 - r^2 - r^2 log(rho^2/r^2))/4. Its Laplacian
// is 1 - pi r^2 delta. The kernel and its slope vanish at r.
double kernel_on_segment(dvec3 begin, dvec3 end, double radius);
double kernel_over(const CutRegion &region, double height, double radius);

} // namespace paradesc
