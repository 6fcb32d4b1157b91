// Centers → groups of nearby centers whose neighborhoods are searched together.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sample/center_point.h"

namespace paradesc {

struct CenterGroups {
  std::vector<int32_t> center; // the centers whose triangles are not left out, group by group
  std::vector<int32_t> begin;  // (groups + 1) into center
};

// Groups have at most `most` centers, and are no wider than a fixed multiple of the radius. rank: the places of triangles in an
// order in which neighbors are near each other on the surface; -1: left out.
CenterGroups group_centers(std::span<const int32_t> rank, const CenterPoints &centers, float radius, int32_t most);

// Joins groups that follow each other while they have at most group_lanes centers and are no wider than that, such as small parts
// of a mesh, and divides groups that are many radii wide.
CenterGroups fit_groups(CenterGroups groups, const CenterPoints &centers, float radius);

} // namespace paradesc
