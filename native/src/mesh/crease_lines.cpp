// Finds lines by union-find, and sums the bends around them in balls that overlap along each line.
#include "mesh/crease_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "mesh/steady_faces.h"
#include "support/parallel.h"
#include "support/pool.h"
#include "support/union_find.h"

namespace paradesc {

namespace {

constexpr int octants = 8;

std::array<int32_t, 2> ends_of(const HalfEdges &half_edges, int32_t edge) {
  return {half_edges.corner_point[edge], half_edges.corner_point[next_corner(edge)]};
}

// Lines are in the order of their first edges.
EdgeLines join(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> edges) {
  const auto points = static_cast<size_t>(half_edges.point_count);
  UnionFind joined(points);
  std::vector<int32_t> number(points, -1), edges_at(points, 0);
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    const auto [begin, end] = ends_of(half_edges, edges[i]);
    joined.join(begin, end);
    ++edges_at[begin];
    ++edges_at[end];
  }
  EdgeLines lines;
  lines.line_of.reserve(edges.size());
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    int32_t &line = number[joined.root_of(half_edges.corner_point[edges[i]])];
    if (line < 0) {
      line = static_cast<int32_t>(lines.line.size());
      lines.line.emplace_back();
    }
    lines.line_of.push_back(line);
    ++lines.line[line].edges;
    for (const int32_t point : ends_of(half_edges, edges[i]))
      lines.line[line].ends += edges_at[point] == 1 && !half_edges.point_boundary[point];
    lines.line[line].length += glm::length(along(triangles, edges[i]));
  }
  return lines;
}

dvec3 middle_of(const Triangles &triangles, int32_t edge) {
  return 0.5 * (dvec3(triangles.position(edge)) + dvec3(triangles.position(next_corner(edge))));
}

// Returns the indices of one edge per line and cell. Edges of a line that lie close together have the same surroundings.
std::vector<int32_t> spread_out(const Triangles &triangles, std::span<const int32_t> edges, const EdgeLines &lines) {
  constexpr double close = 0.4; // of the reach
  using Cell = std::tuple<int32_t, double, double, double>;
  std::vector<std::pair<Cell, int32_t>> places;
  for (size_t i = 0; i < edges.size(); ++i) {
    checkpoint_at(i);
    const int32_t line = lines.line_of[i];
    const dvec3 cell = glm::floor(middle_of(triangles, edges[i]) / (close * lines.line[line].reach));
    places.emplace_back(Cell(line, cell.x, cell.y, cell.z), static_cast<int32_t>(i));
  }
  std::sort(places.begin(), places.end());
  std::vector<int32_t> first;
  for (size_t i = 0; i < places.size(); ++i)
    if (i == 0 || places[i].first != places[i - 1].first) first.push_back(places[i].second);
  return first;
}

// Returns the integral of r^2 - rho^2 along the part of a segment within the ball around the origin.
double bowl_on_segment(dvec3 begin, dvec3 direction, double length, double radius) {
  const double from = glm::dot(begin, direction), half2 = radius * radius - (glm::dot(begin, begin) - from * from);
  if (!(half2 > 0)) return 0;
  const double half = std::sqrt(half2), low = std::max(from, -half), high = std::min(from + length, half);
  const auto up_to = [&](double s) { return half2 * s - s * s * s * (1.0 / 3); };
  return low < high ? up_to(high) - up_to(low) : 0;
}

// Finds the triangles connected within a ball to a place on the surface. One thread reuses it from place to place, so that its
// arrays stay allocated. The surface is borrowed.
class BallFlood {
public:
  BallFlood(const Triangles &triangles, const HalfEdges &half_edges)
      : triangles_(triangles), half_edges_(half_edges), mark_(static_cast<size_t>(triangles.triangle_count), 0) {}

  // center: within the first triangle. The result is valid until the next call.
  const std::vector<int32_t> &run(dvec3 center, int32_t first, double radius) {
    ++places_;
    reached_.clear();
    reach(first);
    const double square = radius * radius;
    for (size_t looked = 0; looked < reached_.size(); ++looked)
      for (int32_t edge = 3 * reached_[looked], last = edge + 3; edge < last; ++edge) {
        const int32_t twin = half_edges_.twin[edge];
        if (twin < 0 || mark_[twin / 3] == places_) continue;
        const dvec3 begin = dvec3(triangles_.position(edge)) - center,
                    end = dvec3(triangles_.position(next_corner(edge))) - center;
        if (glm::dot(begin, begin) < square || glm::dot(end, end) < square || segment_distance2(begin, end) < square)
          reach(twin / 3);
      }
    return reached_;
  }

private:
  void reach(int32_t triangle) {
    mark_[triangle] = places_;
    reached_.push_back(triangle);
  }

  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  std::vector<int32_t> mark_; // (triangles) the last place that reached it
  int32_t places_ = 0;
  std::vector<int32_t> reached_;
};

// The sum of signed bends times the dyads of the edges' directions.
struct BendTensor {
  dvec3 squares_of_axes{0}, products{0}; // xx, yy, zz; yz, zx, xy
  double squares = 0;                    // the squared norm expected for random signs

  void add(double bend, dvec3 direction) {
    const dvec3 scaled = bend * direction;
    squares_of_axes += scaled * direction;
    products += dvec3(scaled.y * direction.z, scaled.z * direction.x, scaled.x * direction.y);
    squares += bend * bend;
  }
  double norm2() const { return glm::dot(squares_of_axes, squares_of_axes) + 2 * glm::dot(products, products); }
};

class Bends {
public:
  Bends(const Triangles &triangles, const HalfEdges &half_edges, std::span<const uint8_t> chosen, std::span<const vec3> normals)
      : triangles_(triangles), half_edges_(half_edges), chosen_(chosen), normals_(normals) {}

  Turning around(int32_t edge, double reach, BallFlood &flood) const {
    const dvec3 center = middle_of(triangles_, edge);
    Turning turning;
    BendTensor all;
    std::array<BendTensor, octants> others;
    for (const int32_t triangle : flood.run(center, edge / 3, reach))
      for (int32_t h = 3 * triangle; h < 3 * triangle + 3; ++h) {
        const int32_t twin = half_edges_.twin[h];
        if (twin <= h) continue;
        const vec3 left = normals_[triangle], right = normals_[twin / 3], apart = left - right;
        if (apart == vec3(0.0f)) continue;
        const dvec3 begin = dvec3(triangles_.position(h)) - center, end = dvec3(triangles_.position(next_corner(h))) - center;
        const double length = glm::length(end - begin);
        if (!(length > 0)) continue;
        const dvec3 direction = (end - begin) * (1 / length), middle = begin + end;
        // The chord of the angle between the normals, negative where the surface is concave.
        const double chord =
                         std::copysign(static_cast<double>(glm::length(apart)), glm::dot(dvec3(cross(left, right)), direction)),
                     bend = bowl_on_segment(begin, direction, length, reach) * chord;
        if (bend == 0) continue;
        all.add(bend, direction);
        (chosen_[h] ? turning.edges : turning.others) += std::abs(bend);
        (chosen_[h] ? turning.sharpness : turning.others_sharpness) += bend * chord;
        if (!chosen_[h]) others[(middle.x > 0) + 2 * (middle.y > 0) + 4 * (middle.z > 0)].add(bend, direction);
      }
    turning.net = std::sqrt(all.norm2());
    turning.sharpness /= std::max(turning.edges, 1e-30);
    turning.others_sharpness /= std::max(turning.others, 1e-30);
    for (const BendTensor &octant : others) turning.others_net2 += octants * (octant.norm2() - octant.squares);
    return turning;
  }

private:
  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  std::span<const uint8_t> chosen_;
  std::span<const vec3> normals_;
};

} // namespace

EdgeLines judge_lines(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> edges,
                      std::span<const uint8_t> chosen, std::span<const vec3> normals, double least_reach, double edges_in_reach,
                      JudgePlace judge, int threads) {
  EdgeLines lines = join(triangles, half_edges, edges);
  for (EdgeLine &line : lines.line) line.reach = std::max(least_reach, edges_in_reach * line.length / line.edges);
  const std::vector<int32_t> places = spread_out(triangles, edges, lines);
  const Bends bends(triangles, half_edges, chosen, normals);
  std::vector<uint8_t> agreed(places.size());
  Pool<BallFlood> pool;
  parallel_blocks(static_cast<int>(places.size()), threads, 16, [&](int begin, int end) {
    pool.with_one([&] { return BallFlood(triangles, half_edges); },
                  [&](BallFlood &flood) {
                    for (int i = begin; i < end; ++i) {
                      const EdgeLine &line = lines.line[lines.line_of[places[i]]];
                      agreed[i] =
                          judge(line, [&](double part) { return bends.around(edges[places[i]], part * line.reach, flood); });
                    }
                  });
  });
  for (size_t i = 0; i < places.size(); ++i) {
    EdgeLine &line = lines.line[lines.line_of[places[i]]];
    ++line.places;
    line.agreed += agreed[i];
  }
  return lines;
}

} // namespace paradesc
