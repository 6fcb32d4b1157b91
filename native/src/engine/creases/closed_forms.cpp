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

// A part of a line within the ball, from low to high, counted from the point nearest to the center; in radii.
struct LinePart {
  double low, high, near2; // squared distance of the line

  double length() const { return high - low; }
  double squares() const { return length() * (near2 + (high * high + high * low + low * low) / 3); } // their integral
  double logarithms() const {                                                                        // of squared distances
    constexpr double least = 1e-24;
    const double near = std::sqrt(near2), of_low = logarithm_of(std::max(near2 + low * low, least)),
                 of_high = logarithm_of(std::max(near2 + high * high, least));
    return high * of_high - low * of_low - 2 * length() + 2 * near * angle_of(near * length(), near2 + low * high);
  }
};

// Returns the integral of across ln(q/h²)/(q - h²) along a line, q the squared distance and h the height. This is the part of an
// integral of logarithms over a plane that is not elementary. Nodes are those of Gauss in t, s = 2 near t/(1 - t²), so that they
// lie closer together near the line's nearest point.
double height_integral(const LinePart &line, double across, double height2) {
  const double near = std::sqrt(line.near2);
  const auto t_of = [&](double s) { return s / (near + std::sqrt(line.near2 + s * s)); };
  const double begin = t_of(line.low), end = t_of(line.high);
  const GaussRule rule = gauss_rule(6);
  double sum = 0;
  for (size_t i = 0; i < rule.nodes.size(); ++i) {
    const double t = begin + rule.nodes[i] * (end - begin), v = 1 / (1 - t * t), s = 2 * near * t * v;
    const double x = (across * across + s * s) / height2;
    constexpr double small = 1e-6;
    sum += rule.weights[i] * (1 + t * t) * v * v * (x > small ? logarithm_of(1 + x) / x : 1 - 0.5 * x);
  }
  return 2 * across * near * (end - begin) * sum / height2;
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

double kernel_on_segment(dvec3 begin, dvec3 end, double radius) {
  const double length = glm::distance(begin, end) / radius;
  if (!(length > 0)) return 0;
  const dvec3 a = begin / radius, along = (end - begin) / (radius * length);
  const double from = glm::dot(a, along), near2 = std::max(glm::dot(a, a) - from * from, 0.0);
  if (!(near2 < 1)) return 0;
  const double half = std::sqrt(1 - near2);
  const LinePart part{std::max(from, -half), std::min(from + length, half), near2};
  if (!(part.low < part.high)) return 0;
  return 0.25 * (part.squares() - part.length() - part.logarithms()) * radius * radius * radius;
}

// With U the kernel's integral over a disc, divided by its angle, a segment adds the integral of U(q) - U(h²) over the angle.
double kernel_over(const CutRegion &region, double height, double radius) {
  constexpr double least_height2 = 1e-12;
  const double height2 = std::max(height * height / (radius * radius), least_height2);
  double sum = region.arcs * (0.0625 - height2 * (0.0625 * height2 - 0.125 * logarithm_of(height2)));
  for (const auto &[begin, end] : region.segments) {
    const double length = glm::distance(begin, end) / radius;
    if (!(length > 0)) continue;
    const dvec2 a = begin / radius, along = (end - begin) / (radius * length);
    const double across = cross(a, along), from = glm::dot(a, along);
    const LinePart part{from, from + length, across * across + height2};
    sum += across * (0.0625 * (part.squares() + height2 * length) - 0.125 * part.logarithms());
    if (height2 > least_height2) sum -= 0.125 * height2 * height_integral(part, across, height2);
  }
  return sum * radius * radius * radius * radius;
}

} // namespace paradesc
