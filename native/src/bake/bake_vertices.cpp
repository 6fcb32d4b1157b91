// Corners, sorted by wedge and group → bake vertices.
#include "bake/bake_vertices.h"

#include <algorithm>
#include <compare>
#include <numeric>

namespace paradesc {

BakeVertices build_bake_vertices(const Triangles &triangles, const Charts &charts, const std::vector<int32_t> &corner_group) {
  struct Key {
    int32_t group, corner;
    auto operator<=>(const Key &) const = default;
  };
  // Corners are sorted by wedge, and those of one wedge by group.
  std::vector<int32_t> begin(charts.wedges.size() + 2, 0);
  for (const int32_t wedge : charts.corner_wedge)
    if (wedge >= 0) ++begin[wedge + 2];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Key> keys(static_cast<size_t>(begin.back()));
  for (int32_t corner = 0; corner < 3 * triangles.triangle_count; ++corner) {
    const int32_t wedge = charts.corner_wedge[corner];
    if (wedge < 0) continue;
    const int32_t group = corner_group.empty() ? corner : corner_group[corner];
    keys[begin[wedge + 1]++] = {group, corner};
  }
  BakeVertices vertices;
  vertices.index.assign(static_cast<size_t>(3 * triangles.triangle_count), 0);
  for (size_t wedge = 0; wedge < charts.wedges.size(); ++wedge) {
    const auto first = static_cast<size_t>(begin[wedge]), last = static_cast<size_t>(begin[wedge + 1]);
    std::sort(keys.begin() + static_cast<ptrdiff_t>(first), keys.begin() + static_cast<ptrdiff_t>(last));
    for (size_t i = first; i < last; ++i) {
      if (i == first || keys[i].group != keys[i - 1].group) {
        vertices.corner.push_back(keys[i].corner);
        vertices.group.push_back(keys[i].group);
      }
      vertices.index[keys[i].corner] = static_cast<uint32_t>(vertices.corner.size() - 1);
    }
  }
  return vertices;
}

} // namespace paradesc
