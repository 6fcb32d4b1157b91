// Computes sums over all triangles in each center's ball, by moments or one by one.
#pragma once

#include <functional>
#include <span>

#include "descriptor/results.h"
#include "engine/cpu/finish.h"
#include "engine/cpu/groups.h"
#include "engine/cpu/patch_samples.h"
#include "engine/cpu/patch_surface.h"
#include "engine/cpu/point_patches.h"

namespace paradesc {

struct ExactPass {
  const PointPatches &patches;
  const PatchSurface &surface;
  const PatchSamples &samples; // the triangles and clusters that are summed one by one
  const SampledSurface &sampled;
  SampleLimit limit;
  const CenterPoints &centers;
  const CenterGroups &groups;                 // of at most group_lanes centers
  std::span<const int32_t> piece_of_triangle; // the connected component of each triangle of the mesh
  const MapValues &map;                       // (centers) values of the map for operators; or empty
  const BallTarget &target;
  const SumTarget &sum_target;
  SumPlan plan;
  EvaluateParams params;
  std::span<const int> rows;
  int threads;
  const std::function<void(double)> &progress; // called with the share of this pass that is done; may throw to cancel
};

// Returns whether any row depends on the noise of positions.
bool asks_for_noise(std::span<const int> rows);

// results: for all centers; unknown_results() before the call.
void evaluate_exactly(const ExactPass &pass, CenterResults &results);

} // namespace paradesc
