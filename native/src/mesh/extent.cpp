// Sums edge lengths in blocks of a fixed size, so that the sum does not depend on the number of threads.
#include "mesh/extent.h"

#include <utility>
#include <vector>

#include "support/parallel.h"

namespace paradesc {

double mean_edge(const Triangles &triangles, const HalfEdges &mesh, int threads) {
  constexpr int block = 65536;
  const int half_edges = 3 * triangles.triangle_count;
  std::vector<std::pair<double, int>> parts(static_cast<size_t>(Blocks{half_edges, block}.number())); // sum and count
  parallel_blocks(half_edges, threads, block, [&](int begin, int end) {
    auto &[sum, count] = parts[begin / block];
    for (int h = begin; h < end; ++h) {
      // Counts each edge once: a pair by its lower half-edge.
      const int32_t twin = mesh.twin[h];
      if (mesh.corner_point[h] < 0 || (twin >= 0 && twin < h)) continue;
      sum += length(dvec3(triangles.position(next_corner(h))) - dvec3(triangles.position(h)));
      ++count;
    }
  });
  double sum = 0.0;
  int count = 0;
  for (const auto &[part, edges] : parts) {
    sum += part;
    count += edges;
  }
  return count ? sum / count : 0.0;
}

Extent measure_extent(const Triangles &triangles, const HalfEdges &half_edges, int threads) {
  Extent extent;
  extent.box = bounding_box(triangles, half_edges, threads);
  extent.diagonal = length(extent.box.high - extent.box.low);
  return extent;
}

} // namespace paradesc
