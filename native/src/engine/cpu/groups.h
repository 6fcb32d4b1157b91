// Centers → groups of nearby centers whose neighborhoods are searched together.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/cpu/surfels.h"

namespace paradesc {

// A place of evaluation.
struct TreeCenter {
  vec3 position;
  vec3 normal;      // unit
  int32_t triangle; // the triangle that it lies on
};
using TreeCenters = UnsetVector<TreeCenter>;

inline constexpr int32_t max_centers = 48; // per group

struct CenterGroups {
  std::vector<int32_t> center; // the centers whose triangles are not left out, group by group
  std::vector<int32_t> begin;  // (groups + 1) into center
};

// Groups have at most max_centers centers, and are no wider than a fixed multiple of the radius.
CenterGroups group_centers(const ClusterTree &tree, const TreeCenters &centers, float radius);

} // namespace paradesc
