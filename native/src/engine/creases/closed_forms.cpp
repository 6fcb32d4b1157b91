// An integral over a region is a sum over its boundary. Each term integrates over the part between the boundary and the foot.
#include "engine/creases/closed_forms.h"

#include <algorithm>
#include <cmath>

#include "support/angle.h"
#include "support/logarithm.h"

namespace paradesc {

namespace {

// Returns the solid angle, seen from the origin, of the triangle between the foot of the origin and a segment, on a plane at this
// height. Its sign is that of the turn around the foot. An arc at distance rho has (1 - height/rho) times its angle.
double solid_angle_of_segment(dvec2 begin, dvec2 end, double height) {
  const dvec2 edge = end - begin;
  const double length = glm::length(edge);
  if (!(length > 0)) return 0;
  const double side = cross(begin, edge) / length, a = std::abs(side), from = glm::dot(begin, edge) / length, to = from + length;
  const double plane2 = a * a + height * height, near = std::sqrt(plane2 + from * from), far = std::sqrt(plane2 + to * to);
  const double turn = angle_of(a * length, a * a + from * to);
  const double angle = turn - angle_of(height * a * (to * near - from * far), a * a * near * far + height * height * from * to);
  return side < 0 ? -angle : angle;
}

// Returns the integral of the kernel along a line at distance a, from the line's nearest point to s.
double kernel_along(double s, double a, double radius) {
  const double square = radius * radius, rho2 = a * a + s * s;
  if (!(rho2 > 0)) return 0;
  return 0.25 * (a * a * s + s * s * s / 3 - square * s) -
         0.25 * square * (s * logarithm_of(std::max(rho2 / square, 1e-24)) - 2 * s + 2 * a * angle_of(s, a));
}

} // namespace

void cut_triangle(const std::array<dvec2, 3> &corners, double radius, CutRegion &region) {
  region.radius = radius;
  region.arcs = 0;
  region.segments.clear();
  const DiscRegion disc = clip_by_disc(corners, radius);
  for (int k = 0; k < disc.count; ++k) {
    const BoundaryPiece &piece = disc.pieces[k];
    if (piece.angle > 0)
      region.arcs += piece.angle;
    else
      region.segments.emplace_back(piece.begin, piece.end);
  }
}

double seen_and_filled(const CutRegion &region, double height, double radius) {
  double solid_angle = (1 - height / radius) * region.arcs, area = 0.5 * region.radius * region.radius * region.arcs;
  for (const auto &[begin, end] : region.segments) {
    solid_angle += solid_angle_of_segment(begin, end, height);
    area += 0.5 * cross(begin, end);
  }
  return solid_angle - height * area / (radius * radius * radius);
}

double kernel_at(double rho2, double radius) {
  const double square = radius * radius, share = rho2 / square;
  return share < 1 ? 0.25 * (rho2 - square - square * logarithm_of(std::max(share, 1e-24))) : 0;
}

GaussRule step_rule(double s, double t, double nearest2) {
  const double middle = 0.5 * (s + t), half = 0.5 * (t - s), share2 = (middle * middle + nearest2) / (half * half);
  return gauss_rule(share2 > 25 ? 3 : share2 > 6 ? 4 : 6);
}

KernelValues kernel_values(double rho2, double radius) {
  const double square = radius * radius, grown = square * logarithm_of(std::max(rho2 / square, 1e-24));
  return {0.25 * (rho2 - square - grown), rho2 * (0.0625 * rho2 - 0.125 * grown)};
}

double kernel_on_segment(dvec3 begin, dvec3 end, double radius) {
  const dvec3 edge = end - begin;
  const double length = glm::length(edge);
  if (!(length > 0)) return 0;
  const double from = glm::dot(begin, edge) / length, to = from + length;
  const double a2 = std::max(glm::dot(begin, begin) - from * from, 0.0), half2 = radius * radius - a2;
  if (!(half2 > 0)) return 0;
  const double half = std::sqrt(half2), low = std::max(from, -half), high = std::min(to, half), a = std::sqrt(a2);
  return low < high ? kernel_along(high, a, radius) - kernel_along(low, a, radius) : 0;
}

// Near the boundary's closest points, the integrand varies no faster than the squared distance.
double kernel_over(const CutRegion &region, double height, double radius) {
  const double low2 = height * height, low = kernel_values(low2, radius).up_to;
  double sum = region.arcs * (kernel_values(radius * radius, radius).up_to - low);
  for (const auto &[begin, end] : region.segments) {
    const dvec2 edge = end - begin;
    const double length = glm::length(edge);
    if (!(length > 0)) continue;
    const double across = cross(begin, edge) / length, across2 = across * across, from = glm::dot(begin, edge) / length;
    const double nearest = std::max(std::sqrt(across2 + low2), least_distance * radius);
    visit_steps(from, from + length, nearest, [&](double s, double t) {
      const GaussRule rule = step_rule(s, t, across2 + low2);
      for (size_t i = 0; i < rule.nodes.size(); ++i) {
        const double place = s + rule.nodes[i] * (t - s), square = across2 + place * place;
        if (square > 0)
          sum += rule.weights[i] * std::abs(t - s) * across / square * (kernel_values(square + low2, radius).up_to - low);
      }
    });
  }
  return sum;
}

} // namespace paradesc
