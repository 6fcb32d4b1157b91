// Rows are computed in double precision, and rounded once.
#include "engine/creases/face_rows.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <thread>

#include "mesh/steady_faces.h"

namespace paradesc {

bool turns(const PlaneTensor &gradient, double radius) {
  constexpr double least_turn = 1e-6;
  return std::max({std::abs(gradient.xx), std::abs(gradient.xy), std::abs(gradient.yy)}) * radius > least_turn;
}

bool is_smooth_bend(const CreasedSurface &surface, int32_t half_edge, float bend) {
  return std::abs(bend) > static_cast<float>(LEAST_BEND) && !surface.creases.contains(half_edge);
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
    if (edge >= 0 && facets.of_triangle[edge / 3] >= 0) return facets.bend_at(edge);
  if (twin < 0) return 0;
  return bend_between(normal, steady_normal(surface.triangles, surface.half_edges, twin / 3),
                      along(surface.triangles, half_edge));
}

double FaceRows::bend_at(int32_t half_edge) const {
  if (surface_.facets.of_triangle[half_edge / 3] >= 0) return surface_.facets.bend_at(half_edge);
  return static_cast<double>(of(half_edge / 3).bend[half_edge % 3]);
}

FaceRows::FaceRows(const CreasedSurface &surface, double radius) : surface_(surface), radius_(radius) {
  const size_t bytes = static_cast<size_t>(surface.triangles.triangle_count) * sizeof(FaceRow);
  size_t room = bytes + alignof(FaceRow);
  memory_.reset(std::calloc(room, 1));
  void *place = memory_.get();
  if (!place) throw std::bad_alloc();
  rows_ = static_cast<FaceRow *>(std::align(alignof(FaceRow), bytes, place, room));
}

void FaceRows::provide(int32_t triangle, FaceRow &row) const {
  int32_t expected = FACE_ABSENT;
  if (__atomic_compare_exchange_n(&row.state, &expected, FACE_BEGUN, false, __ATOMIC_ACQUIRE, __ATOMIC_ACQUIRE))
    __atomic_store_n(&row.state, fill(triangle, row), __ATOMIC_RELEASE);
  while (__atomic_load_n(&row.state, __ATOMIC_ACQUIRE) < FACE_PRESENT) std::this_thread::yield();
}

FaceState FaceRows::fill(int32_t triangle, FaceRow &row) const {
  const FacePlane plane(surface_, triangle);
  const auto put = [](float(&to)[3], dvec3 v) {
    for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(v[k]);
  };
  double longest = 0;
  for (int32_t k = 0; k < 3; ++k) {
    const int32_t edge = 3 * triangle + k, twin = surface_.half_edges.twin[edge];
    put(row.corner[k].place, dvec3(surface_.triangles.position(edge)));
    row.twin[k] = twin < 0 ? NO_TWIN : surface_.facets.of_triangle[twin / 3] >= 0 ? ~twin : twin;
    row.bend[k] = static_cast<float>(bend_of(surface_, edge, plane.normal));
    longest = std::max(longest, glm::length(along(surface_.triangles, edge)));
  }
  if (longest > LARGE_FACE * radius_) return FACE_LARGE;
  if (!(plane.twice_area > 0)) return FACE_PRESENT;
  put(row.normal, plane.normal);
  put(row.axis, plane.axes.first);
  const double area = 0.5 * plane.twice_area;
  PlaneTensor excess{area * plane.gradient.xx, area * plane.gradient.xy, area * plane.gradient.yy};
  for (int32_t k = 0; k < 3; ++k) {
    if (!is_smooth_bend(surface_, 3 * triangle + k, row.bend[k])) continue;
    row.smooth_bend[k] = row.bend[k];
    const dvec2 way = plane.axes.of(along(surface_.triangles, 3 * triangle + k));
    const double length = glm::length(way), share = length > 0 ? 0.5 * static_cast<double>(row.bend[k]) / length : 0;
    excess.xx -= share * way.y * way.y;
    excess.xy += share * way.x * way.y;
    excess.yy -= share * way.x * way.x;
  }
  row.corner[0].other = plane.is_needle ? 0.0f : static_cast<float>(plane.twice_area / (radius_ * radius_));
  row.corner[1].other = static_cast<float>(excess.xx / radius_);
  row.corner[2].other = static_cast<float>(excess.xy / radius_);
  row.excess_yy = static_cast<float>(excess.yy / radius_);
  if (!turns(plane.gradient, radius_)) return FACE_PRESENT;
  row.gradient_xx = static_cast<float>(plane.gradient.xx * radius_);
  row.gradient_xy = static_cast<float>(plane.gradient.xy * radius_);
  row.gradient_yy = static_cast<float>(plane.gradient.yy * radius_);
  return FACE_PRESENT;
}

} // namespace paradesc
