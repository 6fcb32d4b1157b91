// A flood over the mesh: from the triangles at the point over every edge that meets the ball.
#include "sample/reach.h"

#include <algorithm>
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

  // Appends the triangles; nothing where there are too many.
  void run(int32_t point, std::vector<int32_t> &found) {
    const size_t begin = found.size();
    const auto i = static_cast<size_t>(point);
    center_ = dvec3(triangles_.positions[static_cast<size_t>(half_edges_.point_vertex[i])]);
    ++mark_;
    const int32_t first = half_edges_.point_half_edge[i];
    for (int32_t corner = first; corner >= 0;) {
      add(corner / 3, found);
      corner = half_edges_.twin[static_cast<size_t>(previous_corner(corner))];
      if (corner == first) break;
    }
    for (size_t k = begin; k < found.size() && found.size() - begin <= limit_; ++k)
      for (int32_t half_edge = 3 * found[k]; half_edge < 3 * found[k] + 3; ++half_edge) {
        const int32_t twin = half_edges_.twin[static_cast<size_t>(half_edge)];
        if (twin >= 0 && visited_[static_cast<size_t>(twin / 3)] != mark_ &&
            segment_in_ball(offset(half_edge), offset(next_corner(half_edge)), dvec3(0.0), radius_))
          add(twin / 3, found);
      }
    if (found.size() - begin > limit_) found.resize(begin);
    std::sort(found.begin() + static_cast<ptrdiff_t>(begin), found.end());
  }

  // Of one triangle within the ball: cut ones by the middles of 16 pieces.
  double area_of(int32_t triangle) const {
    const dvec3 a = offset(3 * triangle), b = offset(3 * triangle + 1), c = offset(3 * triangle + 2);
    const double area = 0.5 * glm::length(glm::cross(b - a, c - a));
    const double farthest = std::max({dot(a, a), dot(b, b), dot(c, c)});
    if (farthest <= radius_ * radius_) return area;
    int inside = 0;
    auto look = [&](double u, double v) {
      const dvec3 middle = a + (b - a) * u + (c - a) * v;
      inside += dot(middle, middle) < radius_ * radius_;
    };
    for (int i = 0; i < 4; ++i)
      for (int j = 0; i + j < 4; ++j) {
        look((i + 1.0 / 3.0) / 4.0, (j + 1.0 / 3.0) / 4.0);
        if (i + j < 3) look((i + 2.0 / 3.0) / 4.0, (j + 2.0 / 3.0) / 4.0);
      }
    return area * inside / 16.0;
  }

private:
  void add(int32_t triangle, std::vector<int32_t> &found) {
    if (std::exchange(visited_[static_cast<size_t>(triangle)], mark_) != mark_) found.push_back(triangle);
  }

  dvec3 offset(int corner) const {
    return dvec3(triangles_.positions[static_cast<size_t>(triangles_.corner_vertex[static_cast<size_t>(corner)])]) - center_;
  }

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  double radius_;
  size_t limit_;
  std::vector<int32_t> visited_; // (triangle_count) the last run that came by
  dvec3 center_{0.0};
  int32_t mark_ = -1;
};

} // namespace

Reach reach_exactly(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> points, double radius,
                    size_t limit, int threads) {
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
      flood.run(points[i], list);
      reach.begin[i + 1] = static_cast<int32_t>(list.size() - before);
      for (size_t k = before; k < list.size(); ++k) reach.area[i] += flood.area_of(list[k]);
    }
  });
  std::partial_sum(reach.begin.begin(), reach.begin.end(), reach.begin.begin());
  for (const auto &list : found) reach.triangle.insert(reach.triangle.end(), list.begin(), list.end());
  return reach;
}

} // namespace paradesc
