// Triangles in the ball → the tensor, in closed form but for the gradients of normals.
#include "engine/creases/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernel/limits.h"
#include "mesh/quadrature.h"
#include "support/angle.h"
#include "support/logarithm.h"

namespace paradesc {

namespace {

double square_of(dvec3 v) { return glm::dot(v, v); }

double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Of which this is the sine.
double sine_angle(double sine) { return angle_of(sine, std::sqrt(std::max(1 - sine * sine, 0.0))); }

// Of the plane at this height seen from the origin, the solid angle between the foot of the origin and a segment there; its sign
// is that of its turn around the foot. Part of an arc of radius rho sees (1 - height/rho) of its angle.
double solid_angle_of_segment(dvec2 begin, dvec2 end, double height) {
  const dvec2 edge = end - begin;
  const double length = glm::length(edge);
  if (!(length > 0)) return 0;
  const double side = cross(begin, edge) / length, a = std::abs(side);
  const auto up_to = [&](double s) {
    const double span2 = (a * a + s * s) * (a * a + height * height);
    return span2 > 0 ? angle_of(s, a) - sine_angle(height * s / std::sqrt(span2)) : 0.0;
  };
  const double angle = up_to(glm::dot(end, edge) / length) - up_to(glm::dot(begin, edge) / length);
  return side < 0 ? -angle : angle;
}

// From the origin.
double solid_angle_of_triangle(const std::array<dvec3, 3> &corners) {
  const auto &[a, b, c] = corners;
  const double x = glm::length(a), y = glm::length(b), z = glm::length(c);
  return 2 * angle_of(std::abs(glm::dot(a, glm::cross(b, c))),
                      x * y * z + glm::dot(a, b) * z + glm::dot(b, c) * x + glm::dot(c, a) * y);
}

// Integral of |h| (1/rho^3 - 1/r^3) over the region, |h| = height.
double seen_and_filled(const DiscRegion &region, double height, double radius) {
  double solid_angle = 0, area = 0;
  for (int k = 0; k < region.count; ++k) {
    const BoundaryPiece &piece = region.pieces[k];
    if (piece.angle > 0) {
      solid_angle += (1 - height / radius) * piece.angle;
      area += 0.5 * region.radius * region.radius * piece.angle;
    } else {
      solid_angle += solid_angle_of_segment(piece.begin, piece.end, height);
      area += 0.5 * cross(piece.begin, piece.end);
    }
  }
  return solid_angle - height * area / (radius * radius * radius);
}

// Its integral along a line at the distance a, from where that is nearest.
double kernel_along(double s, double a, double radius) {
  const double square = radius * radius, rho2 = a * a + s * s;
  if (!(rho2 > 0)) return 0;
  return 0.25 * (a * a * s + s * s * s / 3 - square * s) -
         0.25 * square * (s * logarithm_of(std::max(rho2 / square, 1e-24)) - 2 * s + 2 * a * angle_of(s, a));
}

// The kernel times the distance, added up to there.
double kernel_up_to(double rho2, double radius) {
  const double square = radius * radius;
  return 0.0625 * rho2 * rho2 - 0.125 * square * rho2 * logarithm_of(std::max(rho2 / square, 1e-24));
}

// The kernel over a region of a plane at this height: around its foot, by what lies between it and the region's boundary, which
// changes no faster than the distance squared where the boundary comes near.
double kernel_over(const DiscRegion &region, double height, double radius) {
  const double low2 = height * height, low = kernel_up_to(low2, radius);
  const GaussRule rule = gauss_rule(6);
  double sum = 0;
  for (int k = 0; k < region.count; ++k) {
    const BoundaryPiece &piece = region.pieces[k];
    if (piece.angle > 0) {
      sum += piece.angle * (kernel_up_to(radius * radius, radius) - low);
      continue;
    }
    const dvec2 edge = piece.end - piece.begin;
    const double across = cross(piece.begin, edge);
    for (size_t i = 0; i < rule.nodes.size(); ++i) {
      const dvec2 place = piece.begin + rule.nodes[i] * edge;
      const double square = glm::dot(place, place);
      if (square > 0) sum += rule.weights[i] * across / square * (kernel_up_to(square + low2, radius) - low);
    }
  }
  return sum;
}

// A vector of a plane with the normal m, turned with it into the plane of n.
dvec3 turned(dvec3 n, dvec3 m, dvec3 v) { return v - (n + m) * (glm::dot(n, v) / std::max(1 + glm::dot(n, m), LEAST_TURN)); }

// The kernel of H for what bends little, of a squared distance: its Laplacian is 1 - pi r^2 delta, and it vanishes at r with its
// slope.
double kernel_at(double rho2, double radius) {
  const double square = radius * radius, share = rho2 / square;
  return share < 1 ? 0.25 * (rho2 - square - square * logarithm_of(std::max(share, 1e-24))) : 0;
}

// Its integral along the segment from a to b.
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

} // namespace

// A bend below this, in radians, and a turn of the normal within the radius, are none.
constexpr double least_turn = 1e-8;

// Symmetric, in the tangent plane of the center.
struct SolidMeasure::Tensor {
  double xx = 0, xy = 0, yy = 0;

  // Half of it in all directions where v has none.
  void add(double amount, dvec2 v) {
    constexpr double no_direction = 1e-4;
    const double square = glm::dot(v, v), share = amount / (square + no_direction);
    xx += share * (v.x * v.x + 0.5 * no_direction);
    xy += share * v.x * v.y;
    yy += share * (v.y * v.y + 0.5 * no_direction);
  }
};

// A triangle from the center.
struct SolidMeasure::Seen {
  const Face &face;
  std::array<dvec3, 3> corners;
  double height;                  // of its plane; 0 where the center lies on it
  double nearest, farthest, size; // distances of corners, the longest edge; squared
  // Whether integrands vary no more over it than they do at such a share of the distance.
  bool is_small(double share) const { return size < share * share * nearest; }
  double middle2() const { return square_of((corners[0] + corners[1] + corners[2]) / 3.0); }
  double edge_middle2(size_t k) const { return square_of(0.5 * (corners[k] + corners[(k + 1) % 3])); }

  // In the triangle's plane, from the foot of the center.
  std::array<dvec2, 3> flat() const {
    const auto in_plane = [&](dvec3 v) { return dvec2(glm::dot(v, face.first), glm::dot(v, face.second)); };
    return {in_plane(corners[0]), in_plane(corners[1]), in_plane(corners[2])};
  }
  // Of a function of the squared distance, over a small triangle.
  template <class Function> double integral(const Function &function) const {
    const double area = 0.5 * face.twice_area;
    if (is_small(0.05)) return area * function(middle2());
    return area * (function(edge_middle2(0)) + function(edge_middle2(1)) + function(edge_middle2(2))) / 3;
  }
};

// ---- Triangles

SolidMeasure::SolidMeasure(const CreasedSurface &surface, double radius)
    : surface_(surface), radius_(radius), face_(static_cast<size_t>(surface.triangles.triangle_count), -1),
      flood_(surface.triangles, surface.half_edges) {}

const SolidMeasure::Face &SolidMeasure::face(int32_t triangle) {
  int32_t &index = face_[triangle];
  if (index >= 0) return faces_[index];
  index = static_cast<int32_t>(faces_.size());
  Face face{};
  const dvec3 a(surface_.triangles.position(3 * triangle)), edge = dvec3(surface_.triangles.position(3 * triangle + 1)) - a;
  const dvec3 product = glm::cross(edge, dvec3(surface_.triangles.position(3 * triangle + 2)) - a);
  face.twice_area = glm::length(product);
  face.is_needle = steady_face(surface_.triangles, surface_.half_edges, triangle) != triangle;
  face.normal = steady_normal(surface_.triangles, surface_.half_edges, triangle);
  const dvec3 in_plane = edge - face.normal * glm::dot(face.normal, edge);
  if (face.twice_area > 0 && glm::dot(in_plane, in_plane) > 0) {
    face.first = glm::normalize(in_plane);
    face.second = glm::cross(face.normal, face.first);
    if (!face.is_needle) face.gradient = gradient_of(triangle, face);
    const double area = 0.5 * face.twice_area;
    face.excess = {area * face.gradient.xx, area * face.gradient.xy, area * face.gradient.yy};
  }
  for (int32_t k = 0; k < 3; ++k) {
    face.bend[k] = bend_at(surface_.triangles, surface_.half_edges, 3 * triangle + k);
    face.is_crease[k] = surface_.creases.half_edge[3 * triangle + k] != 0;
    const dvec3 along =
        dvec3(surface_.triangles.position(3 * triangle + next_corner(k))) - dvec3(surface_.triangles.position(3 * triangle + k));
    const double length = glm::length(along), amount = 0.5 * face.bend[k] * length;
    if (face.is_crease[k] || !(length > 0)) continue;
    const dvec2 across = dvec2(-glm::dot(along, face.second), glm::dot(along, face.first)) / length;
    face.excess.xx -= amount * across.x * across.x;
    face.excess.xy -= amount * across.x * across.y;
    face.excess.yy -= amount * across.y * across.y;
  }
  faces_.push_back(face);
  return faces_.back();
}

// Normals are linear from corner to corner.
SolidMeasure::PlaneTensor SolidMeasure::gradient_of(int32_t triangle, const Face &face) const {
  const auto in_plane = [&](dvec3 v) { return dvec2(glm::dot(v, face.first), glm::dot(v, face.second)); };
  const auto place = [&](int32_t k) { return dvec3(surface_.triangles.position(3 * triangle + k)); };
  const auto normal = [&](int32_t k) { return dvec3(surface_.normals.corner(static_cast<size_t>(3 * triangle + k))); };
  const dvec2 x1 = in_plane(place(1) - place(0)), x2 = in_plane(place(2) - place(0));
  const dvec2 y1 = in_plane(normal(1) - normal(0)), y2 = in_plane(normal(2) - normal(0));
  const auto along_x = [&](double a, double b) { return (a * x2.y - b * x1.y) / face.twice_area; };
  const auto along_y = [&](double a, double b) { return (b * x1.x - a * x2.x) / face.twice_area; };
  return {along_x(y1.x, y2.x), 0.5 * (along_y(y1.x, y2.x) + along_x(y1.y, y2.y)), along_y(y1.y, y2.y)};
}

SolidMeasure::Seen SolidMeasure::see(int32_t triangle) {
  Seen seen{face(triangle), {}, 0, std::numeric_limits<double>::max(), 0, 0};
  bool own = center_.point < 0 && triangle == center_.triangle;
  for (int32_t k = 0; k < 3; ++k) {
    const int32_t corner = 3 * triangle + k;
    seen.corners[k] = dvec3(surface_.triangles.position(corner)) - center_.position;
    own = own || (center_.point >= 0 && surface_.half_edges.corner_point[corner] == center_.point);
    const double square = square_of(seen.corners[k]);
    seen.nearest = std::min(seen.nearest, square);
    seen.farthest = std::max(seen.farthest, square);
  }
  for (size_t k = 0; k < 3; ++k) seen.size = std::max(seen.size, square_of(seen.corners[k] - seen.corners[(k + 1) % 3]));
  if (!own) {
    seen.height = glm::dot(seen.face.normal, seen.corners[0]);
    // A center that needles put off the line between two others lies on what is behind them.
    for (size_t k = 0; k < 3 && std::abs(seen.height) < rounding_; ++k)
      if (segment_distance(seen.corners[k], seen.corners[(k + 1) % 3]) < rounding_) seen.height = 0;
  }
  return seen;
}

// ---- The tensor

SolidTensor SolidMeasure::at(const SolidCenter &center) {
  start(center);
  flood_.grow(radius_);
  const size_t within = flood_.triangles().size();
  flood_.grow(CREASE_REACH * radius_);
  SolidTensor result{smooth_step((CREASE_REACH - nearest_crease() / radius_) / (CREASE_REACH - 1))};
  if (!(result.weight > 0)) return result;
  Tensor tensor, smooth;
  if (center.point >= 0) add_own_edges(tensor);
  for (size_t k = 0; k < within; ++k) {
    const Seen seen = see(flood_.triangles()[k]);
    if (!(seen.face.twice_area > 0)) continue;
    add_face(tensor, seen);
    add_smooth(smooth, seen);
  }
  const double square = radius_ * radius_, hard = 8 / (3 * pi * radius_), soft = 8 / (pi * square * square);
  result.xx = hard * tensor.xx + soft * smooth.xx;
  result.xy = hard * tensor.xy + soft * smooth.xy;
  result.yy = hard * tensor.yy + soft * smooth.yy;
  return result;
}

void SolidMeasure::start(const SolidCenter &center) {
  constexpr size_t most_faces = 1 << 16;
  if (faces_.size() > most_faces) {
    faces_.clear();
    std::fill(face_.begin(), face_.end(), -1);
  }
  center_ = center;
  rounding_ = ROUNDING * std::max({std::abs(center.position.x), std::abs(center.position.y), std::abs(center.position.z)});
  if (center.point >= 0)
    flood_.start_at_point(center.position, center.point);
  else
    flood_.start_in_triangle(center.position, center.triangle);
}

double SolidMeasure::nearest_crease() const {
  double nearest = std::numeric_limits<double>::max();
  for (const int32_t triangle : flood_.triangles())
    for (int32_t edge = 3 * triangle; edge < 3 * triangle + 3; ++edge)
      if (surface_.creases.half_edge[edge])
        nearest = std::min(nearest, segment_distance(dvec3(surface_.triangles.position(edge)) - center_.position,
                                                     dvec3(surface_.triangles.position(next_corner(edge))) - center_.position));
  return nearest;
}

// The edges that start from the point, each with its bend.
void SolidMeasure::add_own_edges(Tensor &tensor) {
  const int32_t first = surface_.half_edges.point_half_edge[center_.point];
  for (int32_t corner = first; corner >= 0;) {
    const dvec3 edge = dvec3(surface_.triangles.position(next_corner(corner))) - center_.position;
    const double length = glm::length(edge);
    if (length > 0)
      tensor.add(face(corner / 3).bend[corner % 3], dvec2(-glm::dot(edge, center_.t2), glm::dot(edge, center_.t1)) / length);
    corner = surface_.half_edges.twin[previous_corner(corner)];
    if (corner == first) break;
  }
}

// What lies above or below the center's own place on the triangle's plane. A center sees nothing of planes that it lies on.
void SolidMeasure::add_face(Tensor &tensor, const Seen &seen) const {
  const double height = std::abs(seen.height), disc2 = radius_ * radius_ - height * height;
  if (height == 0 || seen.face.is_needle || !(disc2 > 0)) return;
  const double cube = radius_ * radius_ * radius_;
  const bool is_within = seen.farthest <= radius_ * radius_;
  double amount = 0;
  if (seen.is_small(0.2) && (is_within || seen.size < 0.0025 * radius_ * radius_)) // the rim may cut it anywhere
    amount = height * seen.integral([&](double rho2) { return std::max(1 / (rho2 * std::sqrt(rho2)) - 1 / cube, 0.0); });
  else if (is_within)
    amount = solid_angle_of_triangle(seen.corners) - 0.5 * height * seen.face.twice_area / cube;
  else
    amount = seen_and_filled(clip_by_disc(seen.flat(), std::sqrt(disc2)), height, radius_);
  tensor.add(seen.height < 0 ? -amount : amount,
             {glm::dot(seen.face.normal, center_.t1), glm::dot(seen.face.normal, center_.t2)});
}

// What its normals turn by, instead of the bends of its edges that are no creases.
void SolidMeasure::add_smooth(Tensor &tensor, const Seen &seen) const {
  const Face &face = seen.face;
  if (seen.is_small(0.2)) return add_in_tangents(tensor, face, face.excess, kernel_at(seen.middle2(), radius_));
  const bool by_middles = seen.is_small(0.45);
  std::array<double, 3> middles{};
  if (by_middles)
    for (size_t k = 0; k < 3; ++k) middles[k] = kernel_at(seen.edge_middle2(k), radius_);
  for (size_t k = 0; k < 3; ++k) {
    if (face.is_crease[k] || !(std::abs(face.bend[k]) > least_turn)) continue;
    const dvec3 begin = seen.corners[k], end = seen.corners[(k + 1) % 3];
    const double length = glm::length(end - begin);
    if (!(length > 0)) continue;
    const double along = by_middles ? length * middles[k] : kernel_on_segment(begin, end, radius_);
    const dvec3 axis = turned(center_.normal, face.normal, end - begin) / length;
    // The triangle behind the edge has the other half.
    tensor.add(-0.5 * face.bend[k] * along, {-glm::dot(axis, center_.t2), glm::dot(axis, center_.t1)});
  }
  const double disc2 = radius_ * radius_ - seen.height * seen.height;
  const PlaneTensor &turn = face.gradient;
  if (!(std::max({std::abs(turn.xx), std::abs(turn.xy), std::abs(turn.yy)}) * radius_ > least_turn) || !(disc2 > 0)) return;
  const double amount = by_middles ? face.twice_area * (middles[0] + middles[1] + middles[2]) / 6
                                   : kernel_over(clip_by_disc(seen.flat(), std::sqrt(disc2)), seen.height, radius_);
  add_in_tangents(tensor, face, turn, amount);
}

// Of a tensor in the plane of a triangle.
void SolidMeasure::add_in_tangents(Tensor &tensor, const Face &face, const PlaneTensor &there, double amount) const {
  const auto in_tangents = [&](dvec3 v) {
    const dvec3 here = turned(center_.normal, face.normal, v);
    return dvec2(glm::dot(here, center_.t1), glm::dot(here, center_.t2));
  };
  const dvec2 u = in_tangents(face.first), v = in_tangents(face.second);
  tensor.xx += amount * (there.xx * u.x * u.x + 2 * there.xy * u.x * v.x + there.yy * v.x * v.x);
  tensor.xy += amount * (there.xx * u.x * u.y + there.xy * (u.x * v.y + u.y * v.x) + there.yy * v.x * v.y);
  tensor.yy += amount * (there.xx * u.y * u.y + 2 * there.xy * u.y * v.y + there.yy * v.y * v.y);
}

} // namespace paradesc
