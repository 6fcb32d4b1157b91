// A place on the surface → the triangles that are connected to it within a ball.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

// The squared distance of the origin from a segment.
inline double segment_distance2(dvec3 a, dvec3 b) {
  const dvec3 edge = b - a;
  const double length2 = glm::dot(edge, edge);
  const double t = length2 > 0 ? std::clamp(-glm::dot(a, edge) / length2, 0.0, 1.0) : 0;
  const dvec3 nearest = a + t * edge;
  return glm::dot(nearest, nearest);
}
inline double segment_distance(dvec3 a, dvec3 b) { return std::sqrt(segment_distance2(a, b)); }

// A flood that one thread reuses from place to place, so that its arrays stay allocated. The surface is borrowed.
class BallFlood {
public:
  BallFlood(const Triangles &triangles, const HalfEdges &half_edges);

  // Starts a flood at a place within a triangle.
  void start_in_triangle(dvec3 center, int32_t triangle);
  // Continues the flood across edges that meet the larger ball, from where the flood of a smaller ball ended.
  void grow(double radius);
  const std::vector<int32_t> &triangles() const { return reached_; } // those of smaller balls first

private:
  void reach(int32_t triangle);
  void cross(int32_t half_edge, double radius);

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  dvec3 center_{0};
  std::vector<int32_t> mark_; // (triangles) the last place that reached it
  int32_t places_ = 0;
  std::vector<int32_t> reached_;
  size_t looked_ = 0;        // rim edges already tested
  std::vector<int32_t> rim_; // half-edges that did not meet the ball
};

} // namespace paradesc
