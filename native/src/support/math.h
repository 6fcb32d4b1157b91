// Vectors for the whole library. Only this file includes GLM.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace paradesc {

using glm::dmat2;
using glm::dmat3;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using glm::ivec2;
using glm::ivec4;
using glm::mat3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

inline constexpr double pi = 3.14159265358979323846;

// Twice the signed area of a triangle in the plane.
inline double cross(dvec2 a, dvec2 b) { return a.x * b.y - a.y * b.x; }

// The box around places; empty until one is added.
template <class V> struct Bounds {
  V low{std::numeric_limits<typename V::value_type>::infinity()}, high{-low};
  void add(const V &place) {
    low = glm::min(low, place);
    high = glm::max(high, place);
  }
  void add(const Bounds &other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
  V size() const { return high - low; }
};

// The unit vector along v, or the other one if v has no direction.
template <class V> V unit_or(const V &v, const V &otherwise) {
  const auto span = glm::length(v);
  return span > 0 && std::isfinite(span) ? v / span : otherwise;
}

// 0 for t <= 0, 1 for t >= 1.
inline double smooth_step(double t) {
  const double inside = std::clamp(t, 0.0, 1.0);
  return inside * inside * (3 - 2 * inside);
}

// A unit vector perpendicular to the unit vector n.
inline dvec3 tangent_of(dvec3 n) { return glm::normalize(glm::cross(n, std::abs(n.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0))); }
inline vec3 tangent_of(vec3 n) { return glm::normalize(glm::cross(n, std::abs(n.x) < 0.6f ? vec3(1, 0, 0) : vec3(0, 1, 0))); }

// The squared distance of the origin from a segment.
inline double segment_distance2(dvec3 a, dvec3 b) {
  const dvec3 edge = b - a;
  const double length2 = glm::dot(edge, edge);
  const double t = length2 > 0 ? std::clamp(-glm::dot(a, edge) / length2, 0.0, 1.0) : 0;
  const dvec3 nearest = a + t * edge;
  return glm::dot(nearest, nearest);
}
inline double segment_distance(dvec3 a, dvec3 b) { return std::sqrt(segment_distance2(a, b)); }

// Half-edge 3t + i runs from corner i of triangle t to the next corner.
inline constexpr int next_corner(int corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
inline constexpr int previous_corner(int corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

} // namespace paradesc
