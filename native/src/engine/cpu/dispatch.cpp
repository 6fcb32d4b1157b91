// The processor → the sums that are compiled for it.
#include "engine/cpu/add_samples.h"

#include "support/instructions.h"

namespace paradesc {

namespace kernels {
#define DECLARE_TARGET(target)                                                                                                   \
  inline namespace target {                                                                                                      \
  extern const SumTarget sums_of_##target;                                                                                       \
  }
DECLARE_TARGET(baseline)
#if defined(__x86_64__)
DECLARE_TARGET(avx2)
DECLARE_TARGET(avx512)
#endif
} // namespace kernels

std::vector<SumTarget> sum_targets() {
  std::vector<SumTarget> targets;
#if defined(__x86_64__)
  const Instructions widest = widest_instructions();
  if (widest == Instructions::avx512) targets.push_back(kernels::sums_of_avx512);
  if (widest != Instructions::baseline) targets.push_back(kernels::sums_of_avx2);
#endif
  targets.push_back(kernels::sums_of_baseline);
  return targets;
}

} // namespace paradesc
