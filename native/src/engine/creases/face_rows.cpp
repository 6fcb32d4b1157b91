// Memory for all rows is reserved, but the system provides only the part that is written: triangles near creases.
#include "engine/creases/face_rows.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "mesh/steady_faces.h"

namespace paradesc {

bool turns(const PlaneTensor &gradient, double radius) {
  constexpr double least_turn = 1e-6;
  return std::max({std::abs(gradient.xx), std::abs(gradient.xy), std::abs(gradient.yy)}) * radius > least_turn;
}

FacePlane::FacePlane(const CreasedSurface &surface, int32_t triangle) : axes{}, gradient{} {
  const Triangles &triangles = surface.triangles;
  const dvec3 edge = along(triangles, 3 * triangle), product = glm::cross(edge, -along(triangles, 3 * triangle + 2));
  const int steady = steady_face(triangles, surface.half_edges, triangle);
  twice_area = glm::length(product);
  is_needle = steady != triangle;
  normal = !is_needle && twice_area > 0 ? product / twice_area : steady_normal(triangles, surface.half_edges, steady);
  const dvec3 first = edge - normal * glm::dot(normal, edge);
  if (!(twice_area > 0 && glm::dot(first, first) > 0)) return;
  axes.first = glm::normalize(first);
  axes.second = glm::cross(normal, axes.first);
  if (is_needle) return;
  NormalGradient found = gradient_times_twice_area(triangles, surface.normals, triangle, axes);
  found.along_first /= twice_area;
  found.along_second /= twice_area;
  gradient = found.in(axes);
}

// Returns the bend between the planes on both sides of an edge. In a facet, the facet's plane replaces the triangle's.
static double bend_of(const CreasedSurface &surface, int32_t half_edge, dvec3 normal) {
  const Facets &facets = surface.facets;
  const int32_t twin = surface.half_edges.twin[half_edge];
  for (const int32_t edge : {half_edge, twin})
    if (edge >= 0 && facets.of_triangle[edge / 3] >= 0) {
      const int32_t side = facets.side_of[edge];
      return side >= 0 ? facets.side[side].bend : 0;
    }
  if (twin < 0) return 0;
  return bend_between(normal, steady_normal(surface.triangles, surface.half_edges, twin / 3),
                      along(surface.triangles, half_edge));
}

FaceRows::FaceRows(const CreasedSurface &surface, double radius)
    : surface_(surface), radius_(radius), rows_(new FaceRow[static_cast<size_t>(surface.triangles.triangle_count)]),
      states_(new std::atomic<uint8_t>[static_cast<size_t>(surface.triangles.triangle_count)]()) {}

const FaceRow &FaceRows::of(int32_t triangle) const {
  std::atomic<uint8_t> &state = states_[static_cast<size_t>(triangle)];
  FaceRow &row = rows_[static_cast<size_t>(triangle)];
  if (state.load(std::memory_order_acquire) == present) return row;
  uint8_t expected = absent;
  if (state.compare_exchange_strong(expected, begun)) {
    row = make(triangle);
    state.store(present, std::memory_order_release);
  }
  while (state.load(std::memory_order_acquire) != present) std::this_thread::yield();
  return row;
}

FaceRow FaceRows::make(int32_t triangle) const {
  FaceRow row{};
  const FacePlane plane(surface_, triangle);
  const auto put = [](float(&to)[3], dvec3 v) {
    for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(v[k]);
  };
  put(row.corner_0, dvec3(surface_.triangles.position(3 * triangle)));
  put(row.corner_1, dvec3(surface_.triangles.position(3 * triangle + 1)));
  put(row.corner_2, dvec3(surface_.triangles.position(3 * triangle + 2)));
  put(row.normal, plane.normal);
  put(row.axis, plane.axes.first);
  const double area = 0.5 * plane.twice_area;
  PlaneTensor excess{area * plane.gradient.xx, area * plane.gradient.xy, area * plane.gradient.yy};
  double longest = 0;
  for (int32_t k = 0; k < 3; ++k) {
    const double bend = bend_of(surface_, 3 * triangle + k, plane.normal);
    row.bend[k] = static_cast<float>(bend);
    const dvec3 way = along(surface_.triangles, 3 * triangle + k);
    const double length = glm::length(way), amount = 0.5 * bend * length;
    longest = std::max(longest, length);
    if (surface_.creases.contains(3 * triangle + k) || !(length > 0)) continue;
    if (std::abs(bend) > LEAST_BEND) row.smooth_bend[k] = static_cast<float>(bend);
    const dvec2 in_plane = plane.axes.of(way), across = dvec2(-in_plane.y, in_plane.x) / length;
    excess.xx -= amount * across.x * across.x;
    excess.xy -= amount * across.x * across.y;
    excess.yy -= amount * across.y * across.y;
  }
  const double square = radius_ * radius_;
  row.twice_area = static_cast<float>(plane.twice_area / square);
  row.seen_area = plane.is_needle ? 0.0f : row.twice_area;
  row.is_large = longest > LARGE_FACE * radius_ ? 1.0f : 0.0f;
  row.excess_xx = static_cast<float>(excess.xx / radius_);
  row.excess_xy = static_cast<float>(excess.xy / radius_);
  row.excess_yy = static_cast<float>(excess.yy / radius_);
  if (!turns(plane.gradient, radius_)) return row;
  row.gradient_xx = static_cast<float>(plane.gradient.xx * radius_);
  row.gradient_xy = static_cast<float>(plane.gradient.xy * radius_);
  row.gradient_yy = static_cast<float>(plane.gradient.yy * radius_);
  return row;
}

} // namespace paradesc
