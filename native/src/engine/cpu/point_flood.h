// The nodes in the balls of a group → the nodes that are connected to their centers within the balls, with one bit per center.
//
// Two adjacent nodes of which one is a cluster count as connected if both positions lie in a ball. If two points share an edge
// and lie in a ball, the edge lies there, too. The other connections are edges that dip into a ball while both ends lie outside.
// They are searched only if some point in a ball is not reached, near the mesh's boundary, and at large triangles, of which a
// ball may contain a part without any corner.
#pragma once

#include <vector>

#include "engine/cpu/ball_sums.h"
#include "engine/cpu/point_patches.h"

namespace paradesc {

// The place from which a center's flood begins.
struct FloodStart {
  int32_t node;     // the center's, or -1
  int32_t triangle; // the single triangle that contains the center, if there is no node
};

// The memory that one thread reuses from group to group.
class PointFlood {
public:
  PointFlood(const PointPatches &patches, const PatchArrays &surface, const BallTarget &target);

  // Fills near.reached, near.whole and near.part. Returns the set of centers that are connected to the mesh's boundary within
  // their balls.
  uint32_t run(const CenterLanes &centers, const FloodStart *starts, NearPatches &near);
  // Returns the set of centers from which a triangle is reached although none of its corners may lie in their balls.
  uint32_t dipped(int32_t triangle) const { return dipped_[triangle]; }
  void forget(); // must follow each run

private:
  void dip_into(int32_t triangle, uint32_t centers);
  uint32_t around(const NearPatches &near, int32_t node) const;
  bool spread(NearPatches &near) const;
  bool dip(const CenterLanes &centers, NearPatches &near);
  void look_at_patches(const NearPatches &near);
  void find_open(const NearPatches &near);
  int32_t list_edges(const NearPatches &near);
  bool go_over(NearPatches &near, const OpenEdge &edge);
  void find_clusters(const CenterLanes &centers, NearPatches &near) const;
  uint32_t boundary(const CenterLanes &centers, const NearPatches &near);

  const PointPatches &patches_;
  const PatchArrays &surface_;
  const BallTarget target_;
  std::vector<uint16_t> dipped_;          // (triangles) balls that reach it across an edge alone
  std::vector<int32_t> dipped_triangles_; // triangles whose entry in dipped_ is not 0
  struct PatchState {
    uint32_t reached, before; // sums of the sets of its nodes and triangles, which only grow: now, and when last looked at
    uint16_t missed, met;     // balls in which points are not reached, or are reached
    bool has_changed() const { return reached != before; }
  };
  struct OpenPatch {
    int32_t patch;
    uint32_t centers; // balls into which its edges may lead on
  };
  std::vector<PatchState> state_; // (patches)
  std::vector<OpenPatch> open_;
  std::vector<OpenEdge> edges_;
};

} // namespace paradesc
