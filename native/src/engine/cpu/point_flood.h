// The points in the balls of a group → the points that are connected to their centers within the balls, with one bit per center.
//
// If two points share an edge and lie in a ball, the edge lies there, too. The other connections are edges that dip into a ball
// while both ends lie outside. They are searched only if some point in a ball is not reached, and near the mesh's boundary.
#pragma once

#include <vector>

#include "engine/cpu/ball_sums.h"
#include "engine/cpu/point_patches.h"

namespace paradesc {

// The memory that one thread reuses from group to group.
class PointFlood {
public:
  PointFlood(const PointPatches &patches, const PatchArrays &surface, const BallTarget &target);

  // The centers are the points from `first` on. Fills near.reached. Returns the set of centers that are connected to the mesh's
  // boundary within their balls.
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
  std::vector<uint16_t> dipped_;          // (triangles) balls that reach it across an edge alone
  std::vector<int32_t> dipped_triangles_; // triangles whose entry in dipped_ is not 0
  std::vector<uint16_t> missed_, met_;    // (patches) balls in which points are not reached, or are reached
  std::vector<int32_t> open_;             // patches whose edges may lead on
};

} // namespace paradesc
