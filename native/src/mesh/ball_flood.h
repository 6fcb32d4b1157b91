// A place on the surface → the triangles that are connected to it within a ball.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

double segment_distance(dvec3 a, dvec3 b); // of the origin

// What one thread keeps from place to place; the surface is borrowed.
class BallFlood {
public:
  BallFlood(const Triangles &triangles, const HalfEdges &half_edges);

  // Around a point of the mesh, or around a place within a triangle.
  void start_at_point(dvec3 center, int32_t point);
  void start_in_triangle(dvec3 center, int32_t triangle);
  // Goes on behind edges that meet the ball, from where an earlier flood of a smaller one ended.
  void grow(double radius);
  const std::vector<int32_t> &triangles() const { return reached_; } // those of smaller balls first

private:
  void start(dvec3 center);
  void reach(int32_t triangle);
  void cross(int32_t half_edge, double radius);

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  dvec3 center_{0};
  std::vector<int32_t> mark_; // (triangles) the last place that reached it
  int32_t places_ = 0;
  std::vector<int32_t> reached_;
  size_t looked_ = 0;        // at so many of them
  std::vector<int32_t> rim_; // half-edges that did not meet the ball
};

} // namespace paradesc
