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
      : triangles_(triangles), half_edges_(half_edges), scale_(static_cast<float>(1.0 / radius)), limit_(limit),
        visited_(static_cast<size_t>(triangles.triangle_count), -1) {}

  // Appends the triangles; nothing where there are too many. Returns their area within the ball.
  double run(int32_t point, std::vector<int32_t> &found) {
    const size_t begin = found.size();
    const auto i = static_cast<size_t>(point);
    const vec3 center = triangles_.positions[static_cast<size_t>(half_edges_.point_vertex[i])];
    ++mark_;
    const int32_t first = half_edges_.point_half_edge[i];
    for (int32_t corner = first; corner >= 0;) {
      add(corner / 3, found);
      corner = half_edges_.twin[static_cast<size_t>(previous_corner(corner))];
      if (corner == first) break;
    }
    double area = 0.0;
    for (size_t k = begin; k < found.size() && found.size() - begin <= limit_; ++k)
      area += static_cast<double>(cross_edges(found[k], center, found));
    if (found.size() - begin <= limit_) return area / (static_cast<double>(scale_) * static_cast<double>(scale_));
    found.resize(begin);
    return 0.0;
  }

private:
  // All in units of the radius, from the center: meshes have any size.
  static bool in_ball(vec3 offset) { return dot(offset, offset) < 1.0f; }

  // Whether the segment between two places outside the ball meets it. Without a division: most do not.
  static bool passes(vec3 a, vec3 b) {
    const vec3 way = b - a;
    const float length = dot(way, way), along = -dot(a, way);
    return along > 0.0f && along < length && (dot(a, a) - 1.0f) * length < along * along;
  }

  // Adds what lies beyond the triangle's edges where they meet the ball; returns its own area within.
  float cross_edges(int32_t triangle, vec3 center, std::vector<int32_t> &found) {
    const size_t first = 3 * static_cast<size_t>(triangle);
    vec3 corner[3];
    bool inside[3];
    for (size_t i = 0; i < 3; ++i) {
      corner[i] = (triangles_.positions[static_cast<size_t>(triangles_.corner_vertex[first + i])] - center) * scale_;
      inside[i] = in_ball(corner[i]);
    }
    for (size_t i = 0; i < 3; ++i) {
      const int32_t twin = half_edges_.twin[first + i];
      if (twin < 0 || visited_[static_cast<size_t>(twin / 3)] == mark_) continue;
      const size_t next = i == 2 ? 0 : i + 1;
      if (inside[i] || inside[next] || passes(corner[i], corner[next])) add(twin / 3, found);
    }
    const vec3 first_side = corner[1] - corner[0], second_side = corner[2] - corner[0];
    const float area = 0.5f * length(cross(first_side, second_side));
    return inside[0] && inside[1] && inside[2] ? area : area * part_in_ball(corner[0], first_side, second_side);
  }

  // By the middles of 16 pieces, of four where the triangle is small.
  static float part_in_ball(vec3 corner, vec3 first_side, vec3 second_side) {
    const bool small = dot(first_side, first_side) + dot(second_side, second_side) < 0.125f;
    const int pieces = small ? 2 : 4;
    const auto step = 1.0f / static_cast<float>(3 * pieces);
    const vec3 first = first_side * step, second = second_side * step;
    int inside = 0;
    for (int i = 0; i < pieces; ++i)
      for (int j = 0; i + j < pieces; ++j) {
        const vec3 lower =
            corner + first * (3.0f * static_cast<float>(i) + 1.0f) + second * (3.0f * static_cast<float>(j) + 1.0f);
        inside += in_ball(lower);
        inside += i + j + 1 < pieces && in_ball(lower + first + second);
      }
    return static_cast<float>(inside) / static_cast<float>(pieces * pieces);
  }

  void add(int32_t triangle, std::vector<int32_t> &found) {
    if (std::exchange(visited_[static_cast<size_t>(triangle)], mark_) != mark_) found.push_back(triangle);
  }

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  float scale_; // 1 / radius
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
    std::vector<int32_t> list; // of its own: neighboring vectors share cache lines
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const size_t before = list.size();
      reach.area[i] = flood.run(points[i], list);
      if (!expected.areas.empty() && std::abs(reach.area[i] - expected.areas[i]) < expected.tolerance) list.resize(before);
      std::sort(list.begin() + static_cast<ptrdiff_t>(before), list.end());
      reach.begin[i + 1] = static_cast<int32_t>(list.size() - before);
    }
    found[static_cast<size_t>(begin / block)] = std::move(list);
  });
  std::partial_sum(reach.begin.begin(), reach.begin.end(), reach.begin.begin());
  for (const auto &list : found) reach.triangle.insert(reach.triangle.end(), list.begin(), list.end());
  return reach;
}

} // namespace paradesc
