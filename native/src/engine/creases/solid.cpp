// Triangles in the ball → the tensor, in closed form except for the gradients of normals.
#include "engine/creases/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/creases/closed_forms.h"
#include "kernel/limits.h"
#include "mesh/ball_flood.h"
#include "mesh/steady_faces.h"
#include "support/cancel.h"

namespace paradesc {

namespace {

double square_of(dvec3 v) { return glm::dot(v, v); }

double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Turns a vector v of a plane with normal m into the plane with normal n.
dvec3 turned(dvec3 n, dvec3 m, dvec3 v) { return v - (n + m) * (glm::dot(n, v) / std::max(1 + glm::dot(n, m), LEAST_TURN)); }

} // namespace

// Adds amount·v̂v̂ᵀ; for a near-zero v, half the amount on each axis.
void SolidMeasure::Tensor::add(double amount, dvec2 v) {
  constexpr double no_direction = 1e-4;
  const double square = glm::dot(v, v), share = amount / (square + no_direction);
  xx += share * (v.x * v.x + 0.5 * no_direction);
  xy += share * v.x * v.y;
  yy += share * (v.y * v.y + 0.5 * no_direction);
}

// A triangle with coordinates relative to the center.
struct SolidMeasure::Seen {
  int32_t triangle;
  const Face &face;
  std::array<dvec3, 3> corners;
  double height;                  // of its plane; 0 if the center lies on it
  double nearest, farthest, size; // squared: distances of corners, and the longest edge
  // Returns whether the triangle is smaller than this share of its distance, so that integrands vary little over it.
  bool is_small(double share) const { return size < share * share * nearest; }
  double middle2() const { return square_of((corners[0] + corners[1] + corners[2]) / 3.0); }
  double edge_middle2(size_t k) const { return square_of(0.5 * (corners[k] + corners[(k + 1) % 3])); }

  // Returns the corners in the triangle's plane, relative to the foot of the center.
  std::array<dvec2, 3> flat() const { return {face.axes.of(corners[0]), face.axes.of(corners[1]), face.axes.of(corners[2])}; }
  // Returns the integral of a function of the squared distance over a small triangle.
  template <class Function> double integral(const Function &function) const {
    const double area = 0.5 * face.twice_area;
    if (is_small(0.05)) return area * function(middle2());
    return area * (function(edge_middle2(0)) + function(edge_middle2(1)) + function(edge_middle2(2))) / 3;
  }
};

// ---- Triangles

SolidMeasure::SolidMeasure(const CreasedSurface &surface, double radius)
    : surface_(surface), radius_(radius), face_(static_cast<size_t>(surface.triangles.triangle_count), -1),
      flood_(surface.triangles, surface.half_edges, surface.facets), edges_(radius) {}

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
  const dvec3 first = edge - face.normal * glm::dot(face.normal, edge);
  if (face.twice_area > 0 && glm::dot(first, first) > 0) {
    face.axes.first = glm::normalize(first);
    face.axes.second = glm::cross(face.normal, face.axes.first);
    if (!face.is_needle) {
      NormalGradient gradient = gradient_times_twice_area(surface_.triangles, surface_.normals, triangle, face.axes);
      gradient.along_first /= face.twice_area;
      gradient.along_second /= face.twice_area;
      face.gradient = gradient.in(face.axes);
    }
    const double area = 0.5 * face.twice_area;
    face.excess = {area * face.gradient.xx, area * face.gradient.xy, area * face.gradient.yy};
  }
  for (int32_t k = 0; k < 3; ++k) {
    face.bend[k] = bend_of(3 * triangle + k);
    face.is_crease[k] = surface_.creases.contains(3 * triangle + k);
    const dvec3 way = along(surface_.triangles, 3 * triangle + k);
    const double length = glm::length(way), amount = 0.5 * face.bend[k] * length;
    if (face.is_crease[k] || !(length > 0)) continue;
    const dvec2 in_plane = face.axes.of(way), across = dvec2(-in_plane.y, in_plane.x) / length;
    face.excess.xx -= amount * across.x * across.x;
    face.excess.xy -= amount * across.x * across.y;
    face.excess.yy -= amount * across.y * across.y;
  }
  faces_.push_back(face);
  return faces_.back();
}

// Returns the bend between the planes on both sides of an edge. In a facet, the facet's plane replaces the triangle's.
double SolidMeasure::bend_of(int32_t half_edge) const {
  const Facets &facets = surface_.facets;
  const int32_t twin = surface_.half_edges.twin[half_edge];
  for (const int32_t edge : {half_edge, twin})
    if (edge >= 0 && facets.of_triangle[edge / 3] >= 0) {
      const int32_t side = facets.side_of[edge];
      return side >= 0 ? facets.side[side].bend : 0;
    }
  return bend_at(surface_.triangles, surface_.half_edges, half_edge);
}

SolidMeasure::Seen SolidMeasure::see(int32_t triangle) {
  Seen seen{triangle, face(triangle), {}, 0, std::numeric_limits<double>::max(), 0, 0};
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
    // A center that is off the line between two others by needles alone lies on the surface behind the needles.
    for (size_t k = 0; k < 3 && std::abs(seen.height) < rounding_; ++k)
      if (segment_distance(seen.corners[k], seen.corners[(k + 1) % 3]) < rounding_) seen.height = 0;
  }
  return seen;
}

// ---- The tensor

SolidTensor SolidMeasure::at(const SolidCenter &center) {
  start(center);
  SolidTensor result{1};
  flood(radius_);
  if (nearest_crease() > radius_) {
    flood(CREASE_REACH * radius_);
    result.weight = smooth_step((CREASE_REACH - nearest_crease() / radius_) / (CREASE_REACH - 1));
    if (!(result.weight > 0)) return result;
    flood(radius_);
  }
  Sums sums;
  if (center.point >= 0) add_own_edges(sums.hard);
  constexpr size_t of_a_millisecond = 1024;
  for (size_t i = 0; i < flood_.triangles().size(); ++i) {
    checkpoint_at(i, of_a_millisecond);
    const Seen seen = see(flood_.triangles()[i]);
    if (!(seen.face.twice_area > 0)) continue;
    add_face(sums, seen);
  }
  for (const FacetPart &part : flood_.parts()) add_part(sums, part);
  const double square = radius_ * radius_, hard = 8 / (3 * pi * radius_), soft = 8 / (pi * square * square);
  result.xx = hard * sums.hard.xx + soft * sums.smooth.xx;
  result.xy = hard * sums.hard.xy + soft * sums.smooth.xy;
  result.yy = hard * sums.hard.yy + soft * sums.smooth.yy;
  return result;
}

void SolidMeasure::start(const SolidCenter &center) {
  constexpr size_t most_faces = 1 << 16;
  if (faces_.size() > most_faces) {
    faces_.clear();
    std::fill(face_.begin(), face_.end(), -1);
  }
  center_ = center;
  edges_.start();
  rounding_ = ROUNDING * std::max({std::abs(center.position.x), std::abs(center.position.y), std::abs(center.position.z)});
}

void SolidMeasure::flood(double radius) { flood_.run(center_.position, center_.point, center_.triangle, radius); }

double SolidMeasure::nearest_crease() const {
  double nearest = std::numeric_limits<double>::max();
  const auto look = [&](dvec3 begin, dvec3 end) {
    nearest = std::min(nearest, segment_distance(begin - center_.position, end - center_.position));
  };
  for (const int32_t triangle : flood_.triangles())
    for (int32_t edge = 3 * triangle; edge < 3 * triangle + 3; ++edge)
      if (surface_.creases.contains(edge))
        look(dvec3(surface_.triangles.position(edge)), dvec3(surface_.triangles.position(next_corner(edge))));
  for (const FacetPart &part : flood_.parts())
    for (const int32_t index : flood_.sides(part))
      if (const FacetSide &side = surface_.facets.side[index]; side.is_crease) look(side.begin, side.end);
  return nearest;
}

// Adds the bends of the edges that start from the point.
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

// Adds the part of the face above or below the center on the triangle's plane. Planes through the center contribute nothing.
void SolidMeasure::add_face(Sums &sums, const Seen &seen) {
  const double height = std::abs(seen.height), disc2 = radius_ * radius_ - height * height, cube = radius_ * radius_ * radius_;
  const bool is_within = seen.farthest <= radius_ * radius_, is_seen = height != 0 && !seen.face.is_needle && disc2 > 0;
  // The rim may cut a small triangle anywhere.
  const bool is_far = seen.is_small(0.2) && (is_within || seen.size < 0.0025 * radius_ * radius_);
  region_.arcs = 0;
  if (!is_within && disc2 > 0 && ((is_seen && !is_far) || !seen.is_small(0.45)))
    cut_triangle(seen.flat(), std::sqrt(disc2), region_);
  double amount = 0;
  if (is_seen && is_far)
    amount = height * seen.integral([&](double rho2) { return std::max(1 / (rho2 * std::sqrt(rho2)) - 1 / cube, 0.0); });
  else if (is_seen && is_within)
    amount = solid_angle_of_triangle(seen.corners) - 0.5 * height * seen.face.twice_area / cube;
  else if (is_seen)
    amount = seen_and_filled(region_, height, radius_);
  add_plane(sums.hard, seen.face.normal, seen.height, amount);
  add_smooth(sums.smooth, seen);
}

// Adds the turning of the face's own normals, and removes the bends at its edges that are not creases.
void SolidMeasure::add_smooth(Tensor &tensor, const Seen &seen) {
  const Face &face = seen.face;
  if (seen.is_small(0.2)) return add_turn(tensor, face.normal, face.axes, face.excess, kernel_at(seen.middle2(), radius_));
  const bool by_middles = seen.is_small(0.45);
  std::array<double, 3> middles{};
  if (by_middles)
    for (size_t k = 0; k < 3; ++k) middles[k] = kernel_at(seen.edge_middle2(k), radius_);
  for (int32_t k = 0; k < 3; ++k) {
    if (face.is_crease[k] || !(std::abs(face.bend[k]) > LEAST_BEND)) continue;
    const dvec3 begin = seen.corners[k], end = seen.corners[(k + 1) % 3];
    const int32_t edge = 3 * seen.triangle + k;
    const double along =
        by_middles ? glm::length(end - begin) * middles[k] : edges_.at(edge, surface_.half_edges.twin[edge], begin, end).along;
    add_bend(tensor, face.normal, end - begin, face.bend[k] * along);
  }
  if (!turns(face.gradient) || !(std::abs(seen.height) < radius_)) return;
  const double amount = by_middles ? face.twice_area * (middles[0] + middles[1] + middles[2]) / 6 : kernel_over_face(seen);
  add_turn(tensor, face.normal, face.axes, face.gradient, amount);
}

// Requires that region_ has the face's arcs.
double SolidMeasure::kernel_over_face(const Seen &seen) {
  double sum =
      region_.arcs * (kernel_values(radius_ * radius_, radius_).up_to - kernel_values(seen.height * seen.height, radius_).up_to);
  for (int32_t k = 0; k < 3; ++k) {
    const dvec3 begin = seen.corners[k], end = seen.corners[(k + 1) % 3];
    const double length = glm::distance(begin, end);
    if (!(length > 0)) continue;
    const int32_t edge = 3 * seen.triangle + k;
    sum += edges_.over(edges_.at(edge, surface_.half_edges.twin[edge], begin, end), seen.height,
                       glm::dot(seen.face.normal, glm::cross(begin, end)) / length);
  }
  return sum;
}

// ---- Contributions

void SolidMeasure::add_plane(Tensor &tensor, dvec3 normal, double height, double amount) const {
  tensor.add(height < 0 ? -amount : amount, {glm::dot(normal, center_.t1), glm::dot(normal, center_.t2)});
}

// Subtracts half of a bend; the other half is subtracted for the face across the edge.
void SolidMeasure::add_bend(Tensor &tensor, dvec3 normal, dvec3 along, double amount) const {
  const double length = glm::length(along);
  if (!(length > 0)) return;
  const dvec3 axis = turned(center_.normal, normal, along) / length;
  tensor.add(-0.5 * amount, {-glm::dot(axis, center_.t2), glm::dot(axis, center_.t1)});
}

void SolidMeasure::add_turn(Tensor &tensor, dvec3 normal, const PlaneAxes &axes, const PlaneTensor &there, double amount) const {
  const auto in_tangents = [&](dvec3 v) {
    const dvec3 here = turned(center_.normal, normal, v);
    return dvec2(glm::dot(here, center_.t1), glm::dot(here, center_.t2));
  };
  const dvec2 u = in_tangents(axes.first), v = in_tangents(axes.second);
  tensor.xx += amount * (there.xx * u.x * u.x + 2 * there.xy * u.x * v.x + there.yy * v.x * v.x);
  tensor.xy += amount * (there.xx * u.x * u.y + there.xy * (u.x * v.y + u.y * v.x) + there.yy * v.x * v.y);
  tensor.yy += amount * (there.xx * u.y * u.y + 2 * there.xy * u.y * v.y + there.yy * v.y * v.y);
}

// Returns whether normals turn by more than their rounding within the radius; ignoring less changes H by at most this over the
// radius.
bool SolidMeasure::turns(const PlaneTensor &gradient) const {
  constexpr double least_turn = 1e-6;
  return std::max({std::abs(gradient.xx), std::abs(gradient.xy), std::abs(gradient.yy)}) * radius_ > least_turn;
}

} // namespace paradesc
