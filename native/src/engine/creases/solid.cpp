// Triangles in the ball → the tensor, in closed form except for the gradients of normals.
#include "engine/creases/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernel/limits.h"
#include "mesh/steady_faces.h"
#include "support/cancel.h"
#include "support/targets.h"

namespace paradesc {

PARADESC_TARGETS(FaceTarget, face_sums_of, face_targets)

namespace {

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

// ---- The tensor

SolidMeasure::SolidMeasure(const SolidSurface &shared)
    : shared_(shared), surface_(shared.parts), radius_(shared.radius), flood_(surface_, shared.rows) {}

bool SolidMeasure::is_near_crease(dvec3 position, int32_t triangle) {
  shared_.near.find(position, triangle, near_);
  return !near_.empty();
}

SolidTensor SolidMeasure::at(const SolidCenter &center) {
  center_ = center;
  rounding_ = ROUNDING * std::max({std::abs(center.position.x), std::abs(center.position.y), std::abs(center.position.z)});
  SolidTensor result{weight()};
  if (!(result.weight > 0)) return result;
  Sums sums;
  if (center.point >= 0) add_own_edges(sums.hard);
  add_triangles(sums);
  for (const FacetPart &part : flood_.parts()) add_part(sums, part);
  const double square = radius_ * radius_, hard = 8 / (3 * pi * radius_), soft = 8 / (pi * square * square);
  result.xx = hard * sums.hard.xx + soft * sums.smooth.xx;
  result.xy = hard * sums.hard.xy + soft * sums.smooth.xy;
  result.yy = hard * sums.hard.yy + soft * sums.smooth.yy;
  return result;
}

void SolidMeasure::flood(double radius) { flood_.run(center_.position, center_.point, center_.triangle, radius); }

// Returns the tensor's weight. If that is not 0, the flood of the ball is done.
double SolidMeasure::weight() {
  if (near_.empty()) return 0;
  if (std::ranges::min(near_, {}, &NearCrease::distance).distance < radius_) {
    flood(radius_);
    if (nearest_reached() < radius_) return 1;
  }
  flood(CREASE_REACH * radius_);
  const double result = smooth_step((CREASE_REACH - nearest_reached() / radius_) / (CREASE_REACH - 1));
  if (result > 0) flood(radius_);
  return result;
}

// Returns the distance of the nearest crease that the flood has reached.
double SolidMeasure::nearest_reached() const {
  double nearest = std::numeric_limits<double>::max();
  for (const NearCrease &crease : near_) {
    if (!(crease.distance < nearest)) continue;
    const int32_t twin = surface_.half_edges.twin[crease.half_edge];
    if (flood_.has_reached(crease.half_edge) || (twin >= 0 && flood_.has_reached(twin))) nearest = crease.distance;
  }
  return nearest;
}

// Adds the bends of the edges that start from the point.
void SolidMeasure::add_own_edges(Tensor &tensor) const {
  for_each_corner_around(surface_.half_edges, center_.point, [&](int32_t corner) {
    const dvec3 edge = dvec3(surface_.triangles.position(next_corner(corner))) - center_.position;
    const double length = glm::length(edge);
    if (length > 0)
      tensor.add(shared_.rows.bend_at(corner), dvec2(-glm::dot(edge, center_.t2), glm::dot(edge, center_.t1)) / length);
  });
}

// ---- Triangles

LaneCenter SolidMeasure::lane_center() const {
  LaneCenter lanes{};
  for (int k = 0; k < 3; ++k) {
    lanes.place[k] = static_cast<float>(center_.position[k]);
    lanes.rest[k] = static_cast<float>(center_.position[k] - static_cast<double>(lanes.place[k]));
    lanes.normal[k] = static_cast<float>(center_.normal[k]);
    lanes.t1[k] = static_cast<float>(center_.t1[k]);
    lanes.t2[k] = static_cast<float>(center_.t2[k]);
  }
  lanes.per_radius = static_cast<float>(1 / radius_);
  lanes.rounding = static_cast<float>(rounding_ / radius_);
  return lanes;
}

void SolidMeasure::add_triangles(Sums &sums) {
  const FaceSums found = shared_.target.add(flood_.rows(), flood_.triangles(), flood_.own_triangles(), lane_center());
  const auto add = [](Tensor &tensor, const float(&of)[3], double unit) {
    tensor.xx += unit * static_cast<double>(of[0]);
    tensor.xy += unit * static_cast<double>(of[1]);
    tensor.yy += unit * static_cast<double>(of[2]);
  };
  add(sums.hard, found.hard, 1);
  add(sums.smooth, found.smooth, radius_ * radius_ * radius_);
  for (const int32_t triangle : flood_.large()) add_large_triangle(sums, triangle);
}

// Adds the solid angle of a triangle, and the turning of its own normals, and removes the bends at its edges that are not
// creases.
void SolidMeasure::add_large_triangle(Sums &sums, int32_t triangle) {
  const FacePlane plane(surface_, triangle);
  const FaceRow &row = shared_.rows.of(triangle);
  std::array<dvec3, 3> corners;
  if (!(plane.twice_area > 0)) return;
  double nearest = std::numeric_limits<double>::max();
  bool is_own = center_.point < 0 && triangle == center_.triangle;
  for (int32_t k = 0; k < 3; ++k) corners[k] = dvec3(surface_.triangles.position(3 * triangle + k)) - center_.position;
  for (size_t k = 0; k < 3; ++k) {
    const dvec3 begin = corners[k], end = corners[(k + 1) % 3];
    nearest = std::min(nearest, segment_distance(begin, end));
    const int32_t edge = 3 * triangle + static_cast<int32_t>(k);
    is_own = is_own || (center_.point >= 0 && surface_.half_edges.corner_point[edge] == center_.point);
    if (is_smooth_bend(surface_, edge, row.bend[k]))
      add_bend(sums.smooth, plane.normal, end - begin, static_cast<double>(row.bend[k]) * kernel_on_segment(begin, end, radius_));
  }
  double height = is_own ? 0 : glm::dot(plane.normal, corners[0]);
  if (std::abs(height) < rounding_ && nearest < rounding_) height = 0;
  const bool is_bent = turns(plane.gradient, radius_), is_seen = height != 0 && !plane.is_needle;
  if (!(std::abs(height) < radius_) || (!is_bent && !is_seen)) return;
  cut_triangle({plane.axes.of(corners[0]), plane.axes.of(corners[1]), plane.axes.of(corners[2])},
               std::sqrt(radius_ * radius_ - height * height), region_);
  if (is_seen) add_plane(sums.hard, plane.normal, height, seen_and_filled(region_, std::abs(height), radius_));
  if (is_bent) add_turn(sums.smooth, plane.normal, plane.axes, plane.gradient, kernel_over(region_, height, radius_));
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

} // namespace paradesc
