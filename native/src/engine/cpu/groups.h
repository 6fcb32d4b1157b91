// Centers → groups of such that lie near each other and look for their neighborhoods together.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/cpu/surfels.h"

namespace paradesc {

// Where something is evaluated.
struct TreeCenter {
  vec3 position;
  vec3 normal;      // unit
  int32_t triangle; // on which it lies
};
using TreeCenters = UnsetVector<TreeCenter>;

inline constexpr int32_t max_centers = 48; // of a group

struct CenterGroups {
  std::vector<int32_t> center; // all centers whose triangle is not left out, group after group
  std::vector<int32_t> begin;  // (groups + 1) into center
};

// Of a few dozens at most, no wider than some part of the radius.
CenterGroups group_centers(const ClusterTree &tree, const TreeCenters &centers, float radius);

} // namespace paradesc
