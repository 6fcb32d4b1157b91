// Orders centers as the tree does, so that neighbors in this order are near each other on the surface.
#include "engine/cpu/groups.h"

#include <limits>
#include <numeric>

#include "support/cancel.h"

namespace paradesc {

static constexpr float max_width = 1; // half the diagonal of the bounding box of a group, over the radius

// Returns all centers whose triangles are not left out.
static std::vector<int32_t> in_order(const ClusterTree &tree, const TreeCenters &centers) {
  std::vector<int32_t> begin(tree.size(0) + 1, 0);
  for (size_t i = 0; i < centers.size(); ++i) {
    checkpoint_at(i);
    if (const int32_t rank = tree.rank[centers[i].triangle]; rank >= 0) ++begin[rank + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int32_t> ordered(static_cast<size_t>(begin.back()));
  for (size_t i = 0; i < centers.size(); ++i) {
    checkpoint_at(i);
    if (const int32_t rank = tree.rank[centers[i].triangle]; rank >= 0) ordered[begin[rank]++] = static_cast<int32_t>(i);
  }
  return ordered;
}

CenterGroups group_centers(const ClusterTree &tree, const TreeCenters &centers, float radius) {
  CenterGroups groups{in_order(tree, centers), {0}};
  const auto count = static_cast<int32_t>(groups.center.size());
  vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (int32_t i = 0; i < count; ++i) {
    checkpoint_at(i);
    const vec3 position = centers[groups.center[i]].position;
    low = glm::min(low, position);
    high = glm::max(high, position);
    const int32_t begin = groups.begin.back();
    if (i == begin || (i - begin < max_centers && length(high - low) <= 2.0f * max_width * radius)) continue;
    groups.begin.push_back(i);
    low = high = position;
  }
  if (count > 0) groups.begin.push_back(count);
  return groups;
}

} // namespace paradesc
