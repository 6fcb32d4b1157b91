// A flood over the mesh: from the triangles at the point over every edge that meets the ball.
#include "sample/reach.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "support/parallel.h"

namespace paradesc {

bool segment_in_ball(dvec3 a, dvec3 b, dvec3 center, double radius) {
  const dvec3 way = b - a;
  const double square = dot(way, way);
  const double t = square > 0.0 ? std::clamp(dot(center - a, way) / square, 0.0, 1.0) : 0.0;
  const dvec3 gap = a + way * t - center;
  return dot(gap, gap) < radius * radius;
}

namespace {

class Flood {
public:
  Flood(const Triangles &triangles, const HalfEdges &half_edges, double radius, size_t limit)
      : triangles_(triangles), half_edges_(half_edges), radius_(radius), limit_(limit),
        visited_(static_cast<size_t>(triangles.triangle_count), -1) {}

  // Appends the triangles; nothing where there are too many. Returns their area within the ball.
  double run(int32_t point, std::vector<int32_t> &found) {
    const size_t begin = found.size();
    const auto i = static_cast<size_t>(point);
    const dvec3 center(triangles_.positions[static_cast<size_t>(half_edges_.point_vertex[i])]);
    ++mark_;
    const int32_t first = half_edges_.point_half_edge[i];
    for (int32_t corner = first; corner >= 0;) {
      add(corner / 3, found);
      corner = half_edges_.twin[static_cast<size_t>(previous_corner(corner))];
      if (corner == first) break;
    }
    double area = 0.0;
    for (size_t k = begin; k < found.size() && found.size() - begin <= limit_; ++k) area += cross_edges(found[k], center, found);
    if (found.size() - begin <= limit_) return area;
    found.resize(begin);
    return 0.0;
  }

private:
  // Adds what lies beyond the triangle's edges where they meet the ball; returns its own area within.
  double cross_edges(int32_t triangle, dvec3 center, std::vector<int32_t> &found) {
    dvec3 corner[3]; // from the center
    bool inside[3];
    for (size_t i = 0; i < 3; ++i) {
      const auto vertex = static_cast<size_t>(triangles_.corner_vertex[3 * static_cast<size_t>(triangle) + i]);
      corner[i] = dvec3(triangles_.positions[vertex]) - center;
      inside[i] = dot(corner[i], corner[i]) < radius_ * radius_;
    }
    for (size_t i = 0; i < 3; ++i) {
      const int32_t twin = half_edges_.twin[3 * static_cast<size_t>(triangle) + i];
      if (twin < 0 || visited_[static_cast<size_t>(twin / 3)] == mark_) continue;
      const size_t next = (i + 1) % 3;
      if (inside[i] || inside[next] || segment_in_ball(corner[i], corner[next], dvec3(0.0), radius_)) add(twin / 3, found);
    }
    const double area = 0.5 * glm::length(glm::cross(corner[1] - corner[0], corner[2] - corner[0]));
    return inside[0] && inside[1] && inside[2] ? area : area * part_in_ball(corner);
  }

  // By the middles of 16 pieces.
  double part_in_ball(const dvec3 (&corner)[3]) const {
    const dvec3 first = (corner[1] - corner[0]) / 12.0, second = (corner[2] - corner[0]) / 12.0;
    int inside = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; i + j < 4; ++j) {
        const dvec3 lower = corner[0] + first * (3.0 * i + 1.0) + second * (3.0 * j + 1.0), upper = lower + first + second;
        inside += dot(lower, lower) < radius_ * radius_;
        inside += i + j < 3 && dot(upper, upper) < radius_ * radius_;
      }
    return inside / 16.0;
  }

  void add(int32_t triangle, std::vector<int32_t> &found) {
    if (std::exchange(visited_[static_cast<size_t>(triangle)], mark_) != mark_) found.push_back(triangle);
  }

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  double radius_;
  size_t limit_;
  std::vector<int32_t> visited_; // (triangle_count) the last run that came by
  int32_t mark_ = -1;
};

} // namespace

Reach reach_exactly(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> points, double radius,
                    size_t limit, int threads, const ExpectedAreas &expected) {
  // Few large blocks: each has marks of its own.
  const auto count = static_cast<int>(points.size());
  const int block = std::max(256, (count + 15) / 16);
  std::vector<std::vector<int32_t>> found(static_cast<size_t>((count + block - 1) / block));
  Reach reach;
  reach.begin.assign(points.size() + 1, 0);
  reach.area.assign(points.size(), 0.0);
  parallel_blocks(count, threads, block, [&](int begin, int end) {
    Flood flood(triangles, half_edges, radius, limit);
    auto &list = found[static_cast<size_t>(begin / block)];
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const size_t before = list.size();
      reach.area[i] = flood.run(points[i], list);
      if (!expected.areas.empty() && std::abs(reach.area[i] - expected.areas[i]) < expected.tolerance) list.resize(before);
      std::sort(list.begin() + static_cast<ptrdiff_t>(before), list.end());
      reach.begin[i + 1] = static_cast<int32_t>(list.size() - before);
    }
  });
  std::partial_sum(reach.begin.begin(), reach.begin.end(), reach.begin.begin());
  for (const auto &list : found) reach.triangle.insert(reach.triangle.end(), list.begin(), list.end());
  return reach;
}

} // namespace paradesc
