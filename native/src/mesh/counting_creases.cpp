// What bends in balls around creases, added up by lines.
#include "mesh/counting_creases.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "kernel/limits.h"
#include "mesh/ball_flood.h"
#include "support/parallel.h"
#include "support/pool.h"

namespace paradesc {

namespace {

struct Bends {
  double creases = 0, others = 0;
};

// Along the segment from a to b, the integral of 1 - rho^2 / r^2 within the ball.
double bowl_on_segment(dvec3 begin, dvec3 end, double radius) {
  const dvec3 edge = end - begin;
  const double length = glm::length(edge);
  if (!(length > 0)) return 0;
  const double from = glm::dot(begin, edge) / length, half2 = radius * radius - (glm::dot(begin, begin) - from * from);
  if (!(half2 > 0)) return 0;
  const double half = std::sqrt(half2), low = std::max(from, -half), high = std::min(from + length, half);
  const auto up_to = [&](double s) { return (half2 * s - s * s * s / 3) / (radius * radius); };
  return low < high ? up_to(high) - up_to(low) : 0;
}

dvec3 middle_of(const Triangles &triangles, int32_t edge) {
  return 0.5 * (dvec3(triangles.position(edge)) + dvec3(triangles.position(next_corner(edge))));
}

// Within this distance of the middle of a crease; its bends are about the angles.
Bends bends_around(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, std::span<const vec3> normals,
                   double reach, int32_t edge, BallFlood &flood) {
  const dvec3 center = middle_of(triangles, edge);
  flood.start_in_triangle(center, edge / 3);
  flood.grow(reach);
  Bends bends;
  for (const int32_t triangle : flood.triangles()) {
    const vec3 own = normals[triangle];
    for (int32_t h = 3 * triangle; h < 3 * triangle + 3; ++h) {
      const int32_t twin = half_edges.twin[h];
      if (twin < 0) continue;
      const vec3 turn = own - normals[twin / 3];
      const float turn2 = dot(turn, turn);
      if (!(turn2 > 0)) continue;
      const dvec3 begin = dvec3(triangles.position(h)) - center, end = dvec3(triangles.position(next_corner(h))) - center;
      (creases.contains(h) ? bends.creases : bends.others) +=
          0.5 * std::sqrt(static_cast<double>(turn2)) * bowl_on_segment(begin, end, reach); // the twin has the other half
    }
  }
  return bends;
}

// One crease of each line in each cell, by their numbers: those that lie close together see the same.
std::vector<int32_t> spread_out(const Triangles &triangles, const Creases &creases, const std::vector<int32_t> &line,
                                double size) {
  using Cell = std::tuple<int32_t, double, double, double>;
  std::vector<std::pair<Cell, int32_t>> places;
  for (size_t i = 0; i < creases.edges.size(); ++i) {
    checkpoint_at(i);
    const dvec3 cell = glm::floor(middle_of(triangles, creases.edges[i]) / size);
    places.emplace_back(Cell(line[i], cell.x, cell.y, cell.z), static_cast<int32_t>(i));
  }
  std::sort(places.begin(), places.end());
  std::vector<int32_t> chosen;
  for (size_t i = 0; i < places.size(); ++i)
    if (i == 0 || places[i].first != places[i - 1].first) chosen.push_back(places[i].second);
  return chosen;
}

} // namespace

Creases creases_that_count(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases,
                           std::span<const vec3> normals, double radius, int threads) {
  if (creases.edges.empty()) return {};
  const Creases marked = marked_creases(triangles, half_edges);
  if (creases == marked) return creases;
  const std::vector<int32_t> line = lines_of(half_edges, creases.edges);
  constexpr double close = 0.5; // of the radius
  const std::vector<int32_t> chosen = spread_out(triangles, creases, line, close * radius);
  std::vector<Bends> bends(chosen.size());
  Pool<BallFlood> pool;
  parallel_blocks(static_cast<int>(chosen.size()), threads, 16, [&](int begin, int end) {
    pool.with_one([&] { return BallFlood(triangles, half_edges); },
                  [&](BallFlood &flood) {
                    for (int i = begin; i < end; ++i)
                      bends[i] = bends_around(triangles, half_edges, creases, normals, CREASE_REACH * radius,
                                              creases.edges[chosen[i]], flood);
                  });
  });
  std::vector<Bends> of_line(static_cast<size_t>(half_edges.point_count));
  for (size_t i = 0; i < chosen.size(); ++i) {
    Bends &all = of_line[line[chosen[i]]];
    all.creases += bends[i].creases;
    all.others += bends[i].others;
  }
  std::vector<int32_t> counting;
  for (size_t i = 0; i < creases.edges.size(); ++i) {
    checkpoint_at(i);
    const Bends &all = of_line[line[i]];
    if (marked.contains(creases.edges[i]) || all.creases >= CREASE_LEAST_SHARE * all.others) counting.push_back(creases.edges[i]);
  }
  return creases_along(half_edges, std::move(counting));
}

} // namespace paradesc
