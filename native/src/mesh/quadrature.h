// Triangle ∩ disc in the triangle's plane → quadrature points with their weights.
//
// The disc is the ball's cut with that plane, its center the origin. The region is convex and bounded by segments and arcs;
// the sector between a star center inside and one piece of the boundary is x(s, t) = c + s (B(t) - c), 0 <= s, t <= 1, with
// Jacobian s |(B - c) x B'|. Tensor Gauss-Legendre rules integrate over it.
#pragma once

#include <array>
#include <cmath>
#include <span>

#include "support/math.h"

namespace paradesc {

struct BoundaryPiece {
  dvec2 begin, end;
  double angle_begin = 0; // of an arc around the origin, counter-clockwise
  double angle = 0;       // 0: a segment
};

struct DiscRegion {
  double radius = 0; // of the disc
  int count = 0;
  std::array<BoundaryPiece, 6> pieces; // counter-clockwise
};

// corners: counter-clockwise. The count is 0 if triangle and disc do not overlap.
DiscRegion clip_by_disc(const std::array<dvec2, 3> &corners, double radius);

// The point of a triangle nearest to the origin. It lies in the region unless that is empty. Integrands vary fastest near the
// ball's center; sectors that start from this point have their nodes closest together there.
dvec2 nearest_to_origin(const std::array<dvec2, 3> &corners);

struct GaussRule {
  std::span<const double> nodes, weights; // on [0, 1]
};

// points: 2, 3, 4, 6, 8 or 12.
GaussRule gauss_rule(int points);

// Calls visit(x, weight) over one sector.
template <class Visit>
void visit_sector(const DiscRegion &region, const BoundaryPiece &piece, dvec2 center, const GaussRule &rule, const Visit &visit) {
  const size_t count = rule.nodes.size();
  for (size_t j = 0; j < count; ++j) {
    dvec2 edge, tangent;
    if (piece.angle > 0) {
      const double angle = piece.angle_begin + rule.nodes[j] * piece.angle;
      edge = region.radius * dvec2(std::cos(angle), std::sin(angle));
      tangent = piece.angle * dvec2(-edge.y, edge.x);
    } else {
      tangent = piece.end - piece.begin;
      edge = piece.begin + rule.nodes[j] * tangent;
    }
    const double jacobian = rule.weights[j] * cross(edge - center, tangent);
    if (jacobian == 0) continue;
    for (size_t i = 0; i < count; ++i)
      visit(center + rule.nodes[i] * (edge - center), jacobian * rule.weights[i] * rule.nodes[i]);
  }
}

// Calls visit(x, angle) along the arcs of the region's rim; angle is the share of the turn that x represents.
template <class Visit> void visit_arcs(const DiscRegion &region, const GaussRule &rule, const Visit &visit) {
  for (int k = 0; k < region.count; ++k) {
    const BoundaryPiece &piece = region.pieces[k];
    if (!(piece.angle > 0)) continue;
    const int parts = static_cast<int>(std::ceil(piece.angle / (0.5 * pi)));
    const double step = piece.angle / parts;
    for (int part = 0; part < parts; ++part)
      for (size_t j = 0; j < rule.nodes.size(); ++j) {
        const double angle = piece.angle_begin + (part + rule.nodes[j]) * step;
        visit(region.radius * dvec2(std::cos(angle), std::sin(angle)), rule.weights[j] * step);
      }
  }
}

// Calls visit(x, weight) over the region.
template <class Visit> void visit_region(const DiscRegion &region, dvec2 center, const GaussRule &rule, const Visit &visit) {
  constexpr double widest_arc = 0.5 * pi;
  for (int k = 0; k < region.count; ++k) {
    BoundaryPiece piece = region.pieces[k];
    const int parts = piece.angle > widest_arc ? static_cast<int>(std::ceil(piece.angle / widest_arc)) : 1;
    piece.angle /= parts;
    for (int part = 0; part < parts; ++part, piece.angle_begin += piece.angle) visit_sector(region, piece, center, rule, visit);
  }
}

} // namespace paradesc
