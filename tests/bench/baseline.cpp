// Half-edges → weighted points and rings → H at each point; see baseline.h.
#include "bench/baseline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <numeric>
#include <random>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace paradesc::bench {
namespace {

// Every third bit of the result is one of value's lowest ten.
uint32_t spread(uint32_t value) {
  value = (value | value << 16) & 0x030000ffu;
  value = (value | value << 8) & 0x0300f00fu;
  value = (value | value << 4) & 0x030c30c3u;
  return (value | value << 2) & 0x09249249u;
}

std::vector<int32_t> morton_order(const std::vector<vec3> &positions) {
  vec3 low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
  for (const vec3 &position : positions) low = glm::min(low, position), high = glm::max(high, position);
  const float scale = 1023.0f / std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-30f});
  std::vector<uint32_t> code(positions.size());
  for (size_t i = 0; i < positions.size(); ++i) {
    const vec3 cell = (positions[i] - low) * scale;
    code[i] = spread(static_cast<uint32_t>(cell.x)) | spread(static_cast<uint32_t>(cell.y)) << 1 |
              spread(static_cast<uint32_t>(cell.z)) << 2;
  }
  std::vector<int32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int32_t a, int32_t b) { return code[static_cast<size_t>(a)] < code[static_cast<size_t>(b)]; });
  return order;
}

// The points at the ends of all edges, both ways, each edge once.
std::vector<std::pair<int32_t, int32_t>> directed_edges(const HalfEdges &half_edges) {
  std::vector<std::pair<int32_t, int32_t>> edges;
  for (size_t h = 0; h < half_edges.twin.size(); ++h) {
    const int32_t from = half_edges.corner_point[h], twin = half_edges.twin[h];
    if (from < 0 || (twin >= 0 && static_cast<size_t>(twin) < h)) continue;
    const int32_t to = half_edges.corner_point[static_cast<size_t>(next_corner(static_cast<int>(h)))];
    edges.emplace_back(from, to);
    edges.emplace_back(to, from);
  }
  return edges;
}

void build_rings(const HalfEdges &half_edges, BaselineSurface &surface) {
  std::vector<int32_t> number(surface.origin.size());
  for (size_t i = 0; i < number.size(); ++i) number[static_cast<size_t>(surface.origin[i])] = static_cast<int32_t>(i);
  const std::vector<std::pair<int32_t, int32_t>> edges = directed_edges(half_edges);
  surface.ring_begin.assign(number.size() + 1, 0);
  for (const auto &[from, to] : edges) ++surface.ring_begin[static_cast<size_t>(number[static_cast<size_t>(from)]) + 1];
  std::partial_sum(surface.ring_begin.begin(), surface.ring_begin.end(), surface.ring_begin.begin());
  std::vector<int32_t> next(surface.ring_begin.begin(), surface.ring_begin.end() - 1);
  surface.ring.resize(edges.size());
  for (const auto &[from, to] : edges)
    surface.ring[static_cast<size_t>(next[static_cast<size_t>(number[static_cast<size_t>(from)])]++)] =
        number[static_cast<size_t>(to)];
}

// One thread's room, made once and large enough for every ball.
struct Room {
  explicit Room(const BaselineSurface &surface)
      : stamp(surface.points.size(), 0), front(surface.points.size() + 1), fresh(surface.points.size() + 1),
        squared(surface.points.size() + 1) {}
  std::vector<uint32_t> stamp;
  uint32_t now = 0;
  std::vector<int32_t> front, fresh; // points to go on from; points met for the first time
  std::vector<float> squared;        // distances of the latter
};

struct Sums {
  double height = 0.0, distance = 0.0; // of w n.d and of w rho
  int64_t count = 0;
};

// Points that the front's edges lead to, each once. A point met before is written over by the next.
size_t meet(const BaselineSurface &surface, Room &room, size_t count) {
  const int32_t *ring = surface.ring.data(), *begin = surface.ring_begin.data(), *front = room.front.data();
  uint32_t *stamp = room.stamp.data();
  int32_t *fresh = room.fresh.data();
  const uint32_t now = room.now;
  size_t found = 0;
  for (size_t i = 0; i < count; ++i) {
    const int32_t end = begin[front[i] + 1];
    for (int32_t k = begin[front[i]]; k < end; ++k) {
      const int32_t point = ring[k];
      fresh[found] = point;
      found += stamp[point] != now;
      stamp[point] = now;
    }
  }
  return found;
}

// Adds the points met that lie in the ball, and keeps them as the new front.
size_t add(const BaselineSurface &surface, Room &room, size_t count, const WeightedPoint &center, vec3 normal, float limit,
           Sums &sums) {
  const WeightedPoint *points = surface.points.data();
  const int32_t *fresh = room.fresh.data();
  float *squared = room.squared.data();
  float height = 0.0f, distance = 0.0f;
  for (size_t i = 0; i < count; ++i) {
    const WeightedPoint &point = points[fresh[i]];
    const float x = point.x - center.x, y = point.y - center.y, z = point.z - center.z;
    const float square = x * x + y * y + z * z;
    const float area = square <= limit ? point.area : 0.0f;
    squared[i] = square;
    distance += area * std::sqrt(square);
    height += area * (normal.x * x + normal.y * y + normal.z * z);
  }
  int32_t *front = room.front.data();
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    front[kept] = fresh[i];
    kept += squared[i] <= limit;
  }
  sums.height += static_cast<double>(height);
  sums.distance += static_cast<double>(distance);
  sums.count += static_cast<int64_t>(kept);
  return kept;
}

Sums flood(const BaselineSurface &surface, Room &room, int32_t point, float limit) {
  if (++room.now == 0) { // after four billion floods
    std::ranges::fill(room.stamp, 0u);
    room.now = 1;
  }
  const auto start = static_cast<size_t>(point);
  room.stamp[start] = room.now;
  room.front[0] = point;
  Sums sums;
  for (size_t count = 1; count > 0;)
    count = add(surface, room, meet(surface, room, count), surface.points[start], surface.normals[start], limit, sums);
  return sums;
}

} // namespace

std::vector<float> voronoi_areas(const Triangles &triangles, const HalfEdges &half_edges) {
  std::vector<double> areas(static_cast<size_t>(half_edges.point_count), 0.0);
  for (size_t c = 0; c < half_edges.corner_point.size(); c += 3) {
    if (half_edges.corner_point[c] < 0) continue;
    dvec3 position[3];
    for (size_t k = 0; k < 3; ++k) position[k] = dvec3(triangles.positions[static_cast<size_t>(triangles.corner_vertex[c + k])]);
    const double twice = length(glm::cross(position[1] - position[0], position[2] - position[0]));
    double cosine[3], square[3]; // of the angle at corner k, scaled; of the side opposite to it
    for (size_t k = 0; k < 3; ++k) {
      const dvec3 &tip = position[k], &a = position[(k + 1) % 3], &b = position[(k + 2) % 3];
      cosine[k] = glm::dot(a - tip, b - tip);
      square[k] = glm::dot(b - a, b - a);
    }
    const bool obtuse = cosine[0] < 0.0 || cosine[1] < 0.0 || cosine[2] < 0.0;
    for (size_t k = 0; k < 3; ++k) {
      const size_t a = (k + 1) % 3, b = (k + 2) % 3;
      const double cell = obtuse ? twice * (cosine[k] < 0.0 ? 0.25 : 0.125)
                                 : (square[a] * cosine[a] + square[b] * cosine[b]) / (8.0 * std::max(twice, 1e-300));
      areas[static_cast<size_t>(half_edges.corner_point[c + k])] += cell;
    }
  }
  return {areas.begin(), areas.end()};
}

BaselineSurface build_baseline(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> point_normals) {
  const auto count = static_cast<size_t>(half_edges.point_count);
  std::vector<vec3> positions(count);
  for (size_t i = 0; i < count; ++i) positions[i] = triangles.positions[static_cast<size_t>(half_edges.point_vertex[i])];
  const std::vector<float> areas = voronoi_areas(triangles, half_edges);
  BaselineSurface surface;
  surface.origin = morton_order(positions);
  surface.points.reserve(count);
  surface.normals.reserve(count);
  for (const int32_t old : surface.origin) {
    const auto i = static_cast<size_t>(old);
    surface.points.push_back({positions[i].x, positions[i].y, positions[i].z, areas[i]});
    surface.normals.push_back(point_normals[i]);
  }
  build_rings(half_edges, surface);
  return surface;
}

BaselineRun run_baseline(const BaselineSurface &surface, double radius, std::span<const int32_t> requested, int threads,
                         std::span<float> values) {
  const auto limit = static_cast<float>(radius * radius);
  const auto count = static_cast<int64_t>(requested.size());
  std::vector<Room> rooms(static_cast<size_t>(std::max(threads, 1)), Room(surface));
  BaselineRun run;
  int64_t neighbors = 0;
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu_start = std::clock();
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads) reduction(+ : neighbors)
#endif
  for (int64_t i = 0; i < count; ++i) {
#ifdef _OPENMP
    Room &room = rooms[static_cast<size_t>(omp_get_thread_num())];
#else
    Room &room = rooms.front();
#endif
    const Sums sums = flood(surface, room, requested[static_cast<size_t>(i)], limit);
    // With V_o = (2 pi r^3/3)(1 - sum w rho a / sum w rho) equation (8) is H = -(8 / 3r) sum w n.d / sum w rho.
    values[static_cast<size_t>(i)] = static_cast<float>(-8.0 / (3.0 * radius) * sums.height / sums.distance);
    neighbors += sums.count;
  }
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  run.cpu_seconds = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  run.neighbors = neighbors;
  return run;
}

std::vector<int32_t> choose_points(const BaselineSurface &surface, int count, uint32_t seed) {
  constexpr size_t run = 64;
  const size_t all = surface.points.size();
  std::vector<int32_t> chosen;
  if (count <= 0 || static_cast<size_t>(count) >= all) {
    chosen.resize(all);
    std::iota(chosen.begin(), chosen.end(), 0);
    return chosen;
  }
  std::mt19937 engine(seed);
  std::vector<int32_t> runs(all / run);
  std::iota(runs.begin(), runs.end(), 0);
  for (size_t i = 0; i < runs.size() && chosen.size() < static_cast<size_t>(count); ++i) {
    std::swap(runs[i], runs[i + engine() % (runs.size() - i)]);
    for (size_t k = 0; k < run; ++k) chosen.push_back(runs[i] * static_cast<int32_t>(run) + static_cast<int32_t>(k));
  }
  std::ranges::sort(chosen);
  return chosen;
}

} // namespace paradesc::bench
