// The processor → the sums that are compiled for it.
#include "engine/cpu/add_samples.h"
#include "engine/cpu/ball_sums.h"
#include "support/instructions.h"

namespace paradesc {

namespace kernels {
#define DECLARE_TARGET(target)                                                                                                   \
  inline namespace target {                                                                                                      \
  extern const SumTarget sums_of_##target;                                                                                       \
  extern const BallTarget ball_sums_of_##target;                                                                                 \
  }
DECLARE_TARGET(baseline)
#if defined(__x86_64__)
DECLARE_TARGET(avx2)
DECLARE_TARGET(avx512)
#endif
} // namespace kernels

// The widest comes first.
template <class Target>
static std::vector<Target> on_this_processor(const Target &baseline
#if defined(__x86_64__)
                                             ,
                                             const Target &avx2, const Target &avx512
#endif
) {
  std::vector<Target> targets;
#if defined(__x86_64__)
  const Instructions widest = widest_instructions();
  if (widest == Instructions::avx512) targets.push_back(avx512);
  if (widest != Instructions::baseline) targets.push_back(avx2);
#endif
  targets.push_back(baseline);
  return targets;
}

#if defined(__x86_64__)
#define ON_THIS_PROCESSOR(sums) on_this_processor(kernels::sums##_baseline, kernels::sums##_avx2, kernels::sums##_avx512)
#else
#define ON_THIS_PROCESSOR(sums) on_this_processor(kernels::sums##_baseline)
#endif
std::vector<SumTarget> sum_targets() { return ON_THIS_PROCESSOR(sums_of); }
std::vector<BallTarget> ball_targets() { return ON_THIS_PROCESSOR(ball_sums_of); }

} // namespace paradesc
