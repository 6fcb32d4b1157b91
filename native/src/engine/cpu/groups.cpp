// Orders centers as their triangles are ordered, so that neighbors in this order are near each other on the surface.
#include "engine/cpu/groups.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/cpu/ball_sums.h"
#include "support/cancel.h"

namespace paradesc {

static constexpr float max_width = 1; // half the diagonal of the bounding box of a group, over the radius

// Returns all centers whose triangles are not left out.
static std::vector<int32_t> in_order(std::span<const int32_t> ranks, const CenterPoints &centers) {
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

static float half(const Bounds<vec3> &bounds) { return 0.5f * length(bounds.size()); }

CenterGroups group_centers(std::span<const int32_t> rank, const CenterPoints &centers, float radius, int32_t most) {
  CenterGroups groups{in_order(rank, centers), {0}};
  const auto count = static_cast<int32_t>(groups.center.size());
  Bounds<vec3> joined;
  for (int32_t i = 0; i < count; ++i) {
    checkpoint_at(i);
    joined.add(centers[groups.center[i]].position);
    const int32_t begin = groups.begin.back();
    if (i == begin || (i - begin < most && half(joined) <= max_width * radius)) continue;
    groups.begin.push_back(i);
    joined = {};
    joined.add(centers[groups.center[i]].position);
  }
  if (count > 0) groups.begin.push_back(count);
  return groups;
}

CenterGroups fit_groups(CenterGroups groups, const CenterPoints &centers, float radius) {
  constexpr float widest = 4.0f; // half of the diagonal over the radius, beyond which a group is divided
  CenterGroups fitted{std::move(groups.center), {0}};
  const auto begin_at = [&](int32_t i) {
    if (i > fitted.begin.back()) fitted.begin.push_back(i);
  };
  Bounds<vec3> joined;
  for (size_t g = 0; g + 1 < groups.begin.size(); ++g) {
    checkpoint_at(g);
    const int32_t first = groups.begin[g], last = groups.begin[g + 1];
    Bounds<vec3> own, both = joined;
    for (int32_t i = first; i < last; ++i) own.add(centers[fitted.center[i]].position);
    both.add(own);
    if (last - fitted.begin.back() <= group_lanes && half(both) <= max_width * radius) {
      joined = both;
      continue;
    }
    begin_at(first);
    joined = own;
    if (half(own) <= widest * radius) continue;
    joined = {};
    for (int32_t i = first; i < last; ++i) {
      joined.add(centers[fitted.center[i]].position);
      if (half(joined) <= widest * radius) continue;
      begin_at(i);
      joined = {};
      joined.add(centers[fitted.center[i]].position);
    }
  }
  begin_at(static_cast<int32_t>(fitted.center.size()));
  return fitted;
}

} // namespace paradesc
