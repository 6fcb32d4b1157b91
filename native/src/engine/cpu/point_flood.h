// The points in the balls of a group → those that are connected to their centers there, for all of them at once, a bit each.
//
// Between two points that share an edge and lie in a ball the edge lies there, too. What is left are edges that dip into a ball
// with both ends outside. They are looked for only where something in a ball is not reached, and beside the mesh's boundary.
#pragma once

#include <vector>

#include "engine/cpu/ball_sums.h"
#include "engine/cpu/point_patches.h"

namespace paradesc {

// The memory that one thread keeps from group to group.
class PointFlood {
public:
  PointFlood(const PointPatches &patches, const PatchArrays &surface, const BallTarget &target);

  // The centers are points from `first` on. Fills near.reached, and returns the set of centers in whose balls the mesh's boundary
  // lies where it is connected to them.
  uint32_t run(const CenterLanes &centers, int32_t first, NearPatches &near);

private:
  bool spread(NearPatches &near) const;
  bool dip(const CenterLanes &centers, NearPatches &near);
  void find_open(const NearPatches &near);
  bool dip_from(const CenterLanes &centers, NearPatches &near, int32_t half_edge);
  uint32_t boundary(const CenterLanes &centers, const NearPatches &near) const;

  const PointPatches &patches_;
  const PatchArrays &surface_;
  const BallTarget target_;
  std::vector<uint16_t> dipped_;          // (triangles) balls that reach a triangle over an edge alone
  std::vector<int32_t> dipped_triangles_; // where that is not 0
  std::vector<uint16_t> missed_, met_;    // (patches) balls in which points are not reached, and are
  std::vector<int32_t> open_;             // patches where edges may lead on
};

} // namespace paradesc
