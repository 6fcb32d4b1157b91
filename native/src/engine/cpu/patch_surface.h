// A mesh at one time → the data that exact sums need, in the order of its patches.
#pragma once

#include <array>
#include <vector>

#include "bake/distortion.h"
#include "engine/cpu/ball_sums.h"
#include "engine/cpu/pieces.h"
#include "engine/cpu/point_patches.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"
#include "support/unset.h"

namespace paradesc {

// Each frame overwrites the same memory.
class PatchSurface {
public:
  struct Needs {
    float large = 0;   // see PatchArrays
    bool sums = true;  // if false, there are no moments and nothing for the rim
    bool noise = true; // if false, noise is 0
  };
  struct Mesh {
    const Triangles &triangles;
    const HalfEdges &half_edges;
    const Normals &normals;
    const BakeSpace &space;
  };
  // Refits to a mesh with these patches. target: see ball_targets().
  void refit(const PointPatches &patches, const Mesh &mesh, const BallTarget &target, const Needs &needs, int threads);

  const PatchArrays &arrays() const { return arrays_; } // valid as long as the patches are
  const Cluster &cluster(int32_t index) const { return cluster_[index]; }
  const std::vector<std::array<vec3, 2>> &rim() const { return rim_edge_; } // the ends of PointPatches::rim

private:
  void resize(const PointPatches &patches, const Needs &needs);
  void sum_clusters(const PointPatches &patches, const Mesh &mesh, const Needs &needs, int threads);
  void place_rims(const PointPatches &patches, const Mesh &mesh);
  void place_nodes(const PointPatches &patches, const Mesh &mesh, int threads);
  void add_cluster_rows(const PointPatches &patches, int32_t batch);
  void join_spheres(int level, int threads);

  PatchArrays arrays_{};
  UnsetVector<float> position_[3], noise_, own_reach_, origin_[3], node_reach_;
  UnsetVector<MomentRow> moment_;
  UnsetVector<uint8_t> apart_, has_long_edge_, has_listed_;
  UnsetVector<RimTriangle> rim_;
  UnsetVector<int32_t> turning_;
  UnsetVector<float> sphere_[3][4]; // by level: middle, reach
  std::vector<Cluster> cluster_;
  std::vector<std::array<vec3, 2>> rim_edge_;
};

} // namespace paradesc
