// The processor → the sums that are compiled for it.
#include "engine/cpu/add_samples.h"

#include <algorithm>

namespace paradesc {

namespace kernels {
#define DECLARE_TARGET(target)                                                                                                   \
  inline namespace target {                                                                                                      \
  extern const AddSamples add_samples_by_kind_of_##target[sum_kinds];                                                            \
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
  __builtin_cpu_init();
  const bool avx512 =
      __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
  if (avx512) targets.push_back({"avx512", kernels::add_samples_by_kind_of_avx512});
  if (__builtin_cpu_supports("avx2")) targets.push_back({"avx2", kernels::add_samples_by_kind_of_avx2});
#endif
  targets.push_back({"baseline", kernels::add_samples_by_kind_of_baseline});
  return targets;
}

} // namespace paradesc
