// The sums of one center → values of descriptors.
#pragma once

#include <span>
#include <vector>

#include "engine/cpu/add_samples.h"
#include "paradesc/paradesc.h"
#include "support/math.h"

#include "shared.h"

namespace paradesc {

// The kind of sums that some rows of the registry need, and how values follow from them.
struct SumPlan {
  SumKind kind;
  bool integral = false; // curvatures follow from the integral invariants
  bool bending = false;  // some value needs to know how normals turn
  friend bool operator==(const SumPlan &, const SumPlan &) = default;
};
SumPlan plan_sums(std::span<const int> rows, const pdesc_options &options, bool windows);

// Appends the values of the rows, component by component; NaN where a value does not exist. boundary: whether the mesh's boundary
// meets the ball.
void finish(const SumPlan &plan, const EvaluateParams &params, const SumCenter &center, const float *sums, bool boundary,
            std::span<const int> rows, std::vector<float> &values);

} // namespace paradesc
