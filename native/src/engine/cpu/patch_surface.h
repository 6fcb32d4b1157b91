// A mesh at one time → the data that exact sums need, in the order of its patches.
#pragma once

#include "bake/distortion.h"
#include "engine/cpu/ball_sums.h"
#include "engine/cpu/point_patches.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"
#include "support/unset.h"

namespace paradesc {

// Each frame overwrites the same memory.
class PatchSurface {
public:
  // Refits to a mesh with these patches. target: see ball_targets(). with_noise: if false, noise is 0.
  void refit(const PointPatches &patches, const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals,
             const BakeSpace &space, const BallTarget &target, bool with_noise, int threads);

  const PatchArrays &arrays() const { return arrays_; }                // valid as long as the patches are
  const float *normal(int axis) const { return normal_[axis].data(); } // (points)

private:
  void resize(const PointPatches &patches);
  void place_points(const PointPatches &patches, const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals,
                    const BakeSpace &space, int threads);
  void join_spheres(int level, int threads);

  PatchArrays arrays_{};
  UnsetVector<float> position_[3], normal_[3], noise_, own_reach_, origin_[3];
  UnsetVector<MomentRow> moment_;
  UnsetVector<uint8_t> apart_;
  UnsetVector<RimTriangle> rim_;
  UnsetVector<float> sphere_[3][4]; // by level: middle, reach
};

} // namespace paradesc
