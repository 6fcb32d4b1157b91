// From the top of the tree down, until a cluster's centers are few and near each other.
#include "engine/cpu/groups.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace paradesc {

namespace {

constexpr int32_t max_centers = 64;
constexpr float max_width = 0.8f; // half the diagonal of the box around a group, of the radius

class Grouping {
public:
  Grouping(const ClusterTree &tree, const std::vector<TreeCenter> &centers, float radius)
      : tree_(tree), centers_(centers), width_(2.0f * max_width * radius), begin_of_triangle_(tree.size(0) + 1, 0) {
    for (const TreeCenter &center : centers)
      if (const int32_t rank = tree.rank[center.triangle]; rank >= 0) ++begin_of_triangle_[rank + 1];
    std::partial_sum(begin_of_triangle_.begin(), begin_of_triangle_.end(), begin_of_triangle_.begin());
    groups_.center.resize(static_cast<size_t>(begin_of_triangle_.back()));
    std::vector<int32_t> next(begin_of_triangle_.begin(), begin_of_triangle_.end() - 1);
    for (size_t i = 0; i < centers.size(); ++i)
      if (const int32_t rank = tree.rank[centers[i].triangle]; rank >= 0) groups_.center[next[rank]++] = static_cast<int32_t>(i);
    groups_.begin.push_back(0);
  }

  CenterGroups run() {
    const size_t top = tree_.levels() - 1;
    for (size_t i = 0; i < tree_.size(top); ++i) divide(top, static_cast<int32_t>(i));
    return std::move(groups_);
  }

private:
  int32_t first_triangle(size_t level, int32_t cluster) const {
    for (; level > 0; --level) cluster = tree_.child_begin[level - 1][cluster];
    return cluster;
  }

  bool is_narrow(int32_t begin, int32_t end) const {
    vec3 low(std::numeric_limits<float>::max()), high(-low);
    for (int32_t i = begin; i < end; ++i) {
      low = glm::min(low, centers_[groups_.center[i]].position);
      high = glm::max(high, centers_[groups_.center[i]].position);
    }
    return !(length(high - low) > width_);
  }

  void divide(size_t level, int32_t cluster) {
    const int32_t begin = begin_of_triangle_[first_triangle(level, cluster)];
    const int32_t end = begin_of_triangle_[first_triangle(level, cluster + 1)];
    if (begin == end) return;
    if (end - begin <= max_centers && is_narrow(begin, end)) {
      groups_.begin.push_back(end);
    } else if (level > 0) {
      for (int32_t k = tree_.child_begin[level - 1][cluster]; k < tree_.child_begin[level - 1][cluster + 1]; ++k)
        divide(level - 1, k);
    } else {
      divide_triangle(begin, end);
    }
  }

  // In rows, as they were listed.
  void divide_triangle(int32_t begin, int32_t end) {
    for (int32_t first = begin, i = begin + 1; i <= end; ++i) {
      const bool ends = i == end || i - first >= max_centers ||
                        length(centers_[groups_.center[i]].position - centers_[groups_.center[first]].position) > 0.5f * width_;
      if (!ends) continue;
      groups_.begin.push_back(i);
      first = i;
    }
  }

  const ClusterTree &tree_;
  const std::vector<TreeCenter> &centers_;
  float width_;
  std::vector<int32_t> begin_of_triangle_;
  CenterGroups groups_;
};

} // namespace

CenterGroups group_centers(const ClusterTree &tree, const std::vector<TreeCenter> &centers, float radius) {
  return Grouping(tree, centers, radius).run();
}

} // namespace paradesc
