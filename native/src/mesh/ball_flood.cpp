#include "mesh/ball_flood.h"

namespace paradesc {

BallFlood::BallFlood(const Triangles &triangles, const HalfEdges &half_edges)
    : triangles_(triangles), half_edges_(half_edges), mark_(static_cast<size_t>(triangles.triangle_count), 0) {}

void BallFlood::start_in_triangle(dvec3 center, int32_t triangle) {
  center_ = center;
  ++places_;
  reached_.clear();
  rim_.clear();
  looked_ = 0;
  reach(triangle);
}

void BallFlood::reach(int32_t triangle) {
  mark_[triangle] = places_;
  reached_.push_back(triangle);
}

void BallFlood::grow(double radius) {
  std::vector<int32_t> rim;
  rim.swap(rim_);
  for (const int32_t edge : rim) cross(edge, radius);
  for (; looked_ < reached_.size(); ++looked_)
    for (int32_t edge = 3 * reached_[looked_], end = edge + 3; edge < end; ++edge) cross(edge, radius);
}

void BallFlood::cross(int32_t edge, double radius) {
  const int32_t twin = half_edges_.twin[edge];
  if (twin < 0 || mark_[twin / 3] == places_) return;
  const dvec3 begin = dvec3(triangles_.position(edge)) - center_, end = dvec3(triangles_.position(next_corner(edge))) - center_;
  const double square = radius * radius;
  if (glm::dot(begin, begin) < square || glm::dot(end, end) < square || segment_distance2(begin, end) < square)
    reach(twin / 3);
  else
    rim_.push_back(edge);
}

} // namespace paradesc
