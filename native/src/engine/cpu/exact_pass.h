// Sums of the shape operator at all points of a mesh, exactly: over triangles, however many a ball has.
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
  const std::function<void(double)> &progress; // of this pass; may throw to cancel
};

// Whether any row is made of the noise of positions.
bool asks_for_noise(std::span<const int> rows);

// results: of all points, not yet known.
void evaluate_exactly(const ExactPass &pass, CenterResults &results);

} // namespace paradesc
