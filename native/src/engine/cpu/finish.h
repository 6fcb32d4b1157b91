// The sums of one center → values of descriptors.
#pragma once

#include <span>
#include <vector>

#include "engine/cpu/add_samples.h"
#include "paradesc/paradesc.h"
#include "support/math.h"

#include "shared.h"

namespace paradesc {

// What is added up for some rows of the registry, and how it is finished.
struct SumPlan {
  SumKind kind;
  bool integral; // the curvatures are those of the integrals
  friend bool operator==(const SumPlan &, const SumPlan &) = default;
};
SumPlan plan_sums(std::span<const int> rows, const pdesc_options &options, bool windows);

// Appends the values of the rows, component by component; NaN where they do not exist. boundary: the mesh's boundary lies in the
// ball.
void finish(const SumPlan &plan, const EvaluateParams &params, const SumCenter &center, const float *sums, bool boundary,
            std::span<const int> rows, std::vector<float> &values);

} // namespace paradesc
