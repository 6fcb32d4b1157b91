// Normals at a triangle's corners → the linear gradient of the normal over the triangle.
#pragma once

#include "mesh/halfedge.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// Two orthogonal unit vectors that span a plane.
struct PlaneAxes {
  dvec3 first, second;

  dvec2 of(dvec3 v) const { return {glm::dot(v, first), glm::dot(v, second)}; }
};

// A symmetric tensor in such a plane.
struct PlaneTensor {
  double xx = 0, xy = 0, yy = 0;
};

// Change of the normal along each axis.
struct NormalGradient {
  dvec3 along_first{0}, along_second{0};

  PlaneTensor in(const PlaneAxes &axes) const {
    const dvec2 x = axes.of(along_first), y = axes.of(along_second);
    return {x.x, 0.5 * (y.x + x.y), y.y};
  }
};

// The gradient, multiplied by twice the triangle's area because the area may be 0.
inline NormalGradient gradient_times_twice_area(const Triangles &triangles, const Normals &normals, int32_t triangle,
                                                const PlaneAxes &axes) {
  const auto place = [&](int32_t k) { return dvec3(triangles.position(3 * triangle + k)); };
  const auto normal = [&](int32_t k) { return dvec3(normals.corner(static_cast<size_t>(3 * triangle + k))); };
  const dvec2 x1 = axes.of(place(1) - place(0)), x2 = axes.of(place(2) - place(0));
  const dvec3 y1 = normal(1) - normal(0), y2 = normal(2) - normal(0);
  return {y1 * x2.y - y2 * x1.y, y2 * x1.x - y1 * x2.x};
}

} // namespace paradesc
