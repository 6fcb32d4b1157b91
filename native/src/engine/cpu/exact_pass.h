// Computes the sums of the shape operator at all points of a mesh exactly, over all triangles in each ball.
#pragma once

#include <functional>
#include <span>

#include "descriptor/results.h"
#include "engine/cpu/finish.h"
#include "engine/cpu/patch_surface.h"
#include "engine/cpu/point_patches.h"

namespace paradesc {

struct ExactPass {
  const PointPatches &patches;
  const PatchSurface &surface;
  const BallTarget &target;
  SumPlan plan;
  EvaluateParams params;
  std::span<const int> rows;
  int threads;
  const std::function<void(double)> &progress; // called with the share of this pass that is done; may throw to cancel
};

// Returns whether any row depends on the noise of positions.
bool asks_for_noise(std::span<const int> rows);

// results: for all points; unknown_results() before the call.
void evaluate_exactly(const ExactPass &pass, CenterResults &results);

} // namespace paradesc
