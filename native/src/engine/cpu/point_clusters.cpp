// Determines bottom-up which clusters of the tree are small, and takes the largest of them.
#include "engine/cpu/point_clusters.h"

#include <algorithm>
#include <atomic>

#include "support/parallel.h"
#include "support/unset.h"

namespace paradesc {

namespace {

constexpr int clusters_of_block = 4096;
constexpr int32_t least_points = 3; // of a cluster; fewer are faster one by one

// Means over the points of a cluster.
struct Size {
  vec3 middle, normal, facing;
  float spread, points;
  bool is_small;
};

Size join(std::span<const Size> parts) {
  Size whole{};
  whole.is_small = true;
  for (const Size &part : parts) {
    whole.points += part.points;
    whole.middle += part.points * (part.middle - parts[0].middle);
    whole.normal += part.points * part.normal;
    whole.facing += part.points * part.facing;
    whole.is_small = whole.is_small && part.is_small;
  }
  whole.middle /= whole.points;
  whole.normal /= whole.points;
  whole.facing /= whole.points;
  for (const Size &part : parts) {
    const vec3 gap = part.middle - parts[0].middle - whole.middle;
    whole.spread += part.points * (part.spread + dot(gap, gap)) / whole.points;
  }
  whole.middle += parts[0].middle;
  return whole;
}

} // namespace

std::vector<int32_t> plan_nodes(const PointOrder &order, const PointSurface &surface, const ClusterLimit &limit, int threads) {
  const auto points = static_cast<size_t>(order.points());
  std::vector<int32_t> end(points, 0); // of the largest small cluster that begins at a point
  UnsetVector<Size> below(points), sizes;
  const auto for_each = [&](size_t count, const auto &body) {
    parallel_blocks(static_cast<int>(count), threads, clusters_of_block, [&](int first, int last) {
      for (int i = first; i < last; ++i) body(static_cast<size_t>(i));
    });
  };
  for_each(points, [&](size_t i) {
    const auto point = static_cast<size_t>(order.tree.item[i]);
    const vec3 position = surface.position[point], normal = surface.normal[point],
               facing = surface.facing.empty() ? normal : surface.facing[point];
    bool is_small = true;
    for (int32_t k = order.neighbors.begin[point]; k < order.neighbors.begin[point + 1]; ++k) {
      const vec3 edge = surface.position[order.neighbors.neighbor[k]] - position;
      is_small = is_small && dot(edge, edge) <= 2.0f * limit.spread;
    }
    below[i] = {position, normal, facing, 0.0f, 1.0f, is_small};
  });
  for (size_t level = 1; level < order.tree.levels(); ++level) {
    std::atomic<bool> any_small{false};
    sizes.resize(order.tree.size(level));
    const std::vector<int32_t> &children = order.tree.child_begin[level - 1], &begin = order.begin[level];
    for_each(sizes.size(), [&](size_t i) {
      Size &size = sizes[i];
      size = join(std::span(below).subspan(static_cast<size_t>(children[i]), static_cast<size_t>(children[i + 1] - children[i])));
      size.is_small = size.is_small && size.spread <= limit.spread && dot(size.normal, size.normal) > limit.coherence &&
                      dot(size.facing, size.facing) > limit.coherence;
      if (!size.is_small) return;
      any_small = true;
      if (begin[i + 1] - begin[i] >= least_points) end[begin[i]] = begin[i + 1];
    });
    if (!any_small) break;
    below.swap(sizes);
  }
  std::vector<int32_t> nodes;
  for (int32_t i = 0; i < order.points(); i = std::max(end[i], i + 1)) nodes.push_back(i);
  nodes.push_back(order.points());
  return nodes;
}

} // namespace paradesc
