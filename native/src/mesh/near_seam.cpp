// Shortest edge paths from all seams at once (Dijkstra), up to the radius.
#include "mesh/near_seam.h"

#include <limits>
#include <queue>

#include "mesh/cluster_tree.h"

namespace paradesc {

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
  const PointNeighbors neighbors = find_point_neighbors(half_edges);
  auto position = [&](int32_t point) { return dvec3(triangles.positions[half_edges.point_vertex[point]]); };
  while (!queue.empty()) {
    const auto [so_far, point] = queue.top();
    queue.pop();
    if (so_far > distance[point]) continue;
    for (int32_t i = neighbors.begin[point]; i < neighbors.begin[point + 1]; ++i) {
      const int32_t other = neighbors.neighbor[i];
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
