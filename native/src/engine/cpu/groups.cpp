// Orders centers as their triangles are ordered, so that neighbors in this order are near each other on the surface.
#include "engine/cpu/groups.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "engine/cpu/ball_sums.h"
#include "support/cancel.h"

namespace paradesc {

static constexpr float max_width = 1; // half the diagonal of the bounding box of a group, over the radius

// Returns all centers whose triangles are not left out.
static std::vector<int32_t> in_order(std::span<const int32_t> ranks, const TreeCenters &centers) {
  int32_t last = -1;
  for (const int32_t rank : ranks) last = std::max(last, rank);
  std::vector<int32_t> begin(static_cast<size_t>(last) + 2, 0);
  for (size_t i = 0; i < centers.size(); ++i) {
    checkpoint_at(i);
    if (const int32_t rank = ranks[centers[i].triangle]; rank >= 0) ++begin[rank + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int32_t> ordered(static_cast<size_t>(begin.back()));
  for (size_t i = 0; i < centers.size(); ++i) {
    checkpoint_at(i);
    if (const int32_t rank = ranks[centers[i].triangle]; rank >= 0) ordered[begin[rank]++] = static_cast<int32_t>(i);
  }
  return ordered;
}

CenterGroups group_centers(std::span<const int32_t> rank, const TreeCenters &centers, float radius, int32_t most) {
  CenterGroups groups{in_order(rank, centers), {0}};
  const auto count = static_cast<int32_t>(groups.center.size());
  vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (int32_t i = 0; i < count; ++i) {
    checkpoint_at(i);
    const vec3 position = centers[groups.center[i]].position;
    low = glm::min(low, position);
    high = glm::max(high, position);
    const int32_t begin = groups.begin.back();
    if (i == begin || (i - begin < most && length(high - low) <= 2.0f * max_width * radius)) continue;
    groups.begin.push_back(i);
    low = high = position;
  }
  if (count > 0) groups.begin.push_back(count);
  return groups;
}

CenterGroups join_groups(const CenterGroups &groups, const TreeCenters &centers, float radius) {
  CenterGroups joined{groups.center, {0}};
  vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (size_t g = 0; g + 1 < groups.begin.size(); ++g) {
    checkpoint_at(g);
    vec3 own_low(std::numeric_limits<float>::max()), own_high(-own_low);
    for (int32_t i = groups.begin[g]; i < groups.begin[g + 1]; ++i) {
      own_low = glm::min(own_low, centers[groups.center[i]].position);
      own_high = glm::max(own_high, centers[groups.center[i]].position);
    }
    low = glm::min(low, own_low);
    high = glm::max(high, own_high);
    const bool is_full =
        groups.begin[g + 1] - joined.begin.back() > group_lanes || length(high - low) > 2.0f * max_width * radius;
    if (!is_full || groups.begin[g] == joined.begin.back()) continue;
    joined.begin.push_back(groups.begin[g]);
    low = own_low;
    high = own_high;
  }
  if (!groups.center.empty()) joined.begin.push_back(groups.begin.back());
  return joined;
}

} // namespace paradesc
