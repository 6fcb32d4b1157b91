// Shortest edge paths from all seams at once (Dijkstra), up to the radius.
#include "mesh/near_seam.h"

#include <limits>
#include <queue>

namespace paradesc {

// Neighbors of each point along edges, as flat lists.
struct EdgeLists {
  std::vector<int32_t> begin, point;
};

static EdgeLists edge_lists(const HalfEdges &half_edges) {
  EdgeLists lists;
  lists.begin.assign(static_cast<size_t>(half_edges.point_count) + 1, 0);
  auto each_end = [&](const auto &visit) {
    for (int corner = 0; corner < static_cast<int>(half_edges.corner_point.size()); ++corner) {
      const int32_t a = half_edges.corner_point[corner];
      const int32_t b = half_edges.corner_point[next_corner(corner)];
      if (a < 0) continue;
      visit(a, b);
      visit(b, a);
    }
  };
  each_end([&](int32_t a, int32_t) { ++lists.begin[a + 1]; });
  for (size_t i = 1; i < lists.begin.size(); ++i) lists.begin[i] += lists.begin[i - 1];
  lists.point.resize(static_cast<size_t>(lists.begin.back()));
  std::vector<int32_t> next(lists.begin.begin(), lists.begin.end() - 1);
  each_end([&](int32_t a, int32_t b) { lists.point[next[a]++] = b; });
  return lists;
}

std::vector<uint8_t> vertices_near_seams(const Triangles &triangles, const HalfEdges &half_edges, const Charts &charts,
                                         double radius) {
  using Entry = std::pair<double, int32_t>;
  std::vector<double> distance(static_cast<size_t>(half_edges.point_count), std::numeric_limits<double>::infinity());
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const Border &border : charts.borders) {
    if (border.kind != BorderKind::seam) continue;
    const int32_t point = half_edges.corner_point[border.half_edge];
    if (distance[point] == 0.0) continue;
    distance[point] = 0.0;
    queue.emplace(0.0, point);
  }
  const EdgeLists edges = edge_lists(half_edges);
  auto position = [&](int32_t point) { return dvec3(triangles.positions[half_edges.point_vertex[point]]); };
  while (!queue.empty()) {
    const auto [so_far, point] = queue.top();
    queue.pop();
    if (so_far > distance[point]) continue;
    for (int32_t i = edges.begin[point]; i < edges.begin[point + 1]; ++i) {
      const int32_t other = edges.point[i];
      const double way = so_far + length(position(other) - position(point));
      if (way > radius || way >= distance[other]) continue;
      distance[other] = way;
      queue.emplace(way, other);
    }
  }
  std::vector<uint8_t> near(static_cast<size_t>(triangles.vertex_count), 0);
  for (size_t vertex = 0; vertex < near.size(); ++vertex) {
    const int32_t point = half_edges.vertex_point[vertex];
    near[vertex] = point >= 0 && distance[point] <= radius;
  }
  return near;
}

} // namespace paradesc
