// The processor → the objects that are compiled for each of its instruction sets.
#pragma once

#include <vector>

#include "support/instructions.h"

// Declares a constant object `name_target` of some type for each instruction set, as the files that are compiled for it define
// it.
#define PARADESC_DECLARE_TARGET(Type, name, target)                                                                              \
  inline namespace target {                                                                                                      \
  extern const Type name##_##target;                                                                                             \
  }
#if defined(__x86_64__)
#define PARADESC_DECLARE_TARGETS(Type, name)                                                                                     \
  namespace kernels {                                                                                                            \
  PARADESC_DECLARE_TARGET(Type, name, baseline)                                                                                  \
  PARADESC_DECLARE_TARGET(Type, name, avx2)                                                                                      \
  PARADESC_DECLARE_TARGET(Type, name, avx512)                                                                                    \
  }
#define PARADESC_ON_THIS_PROCESSOR(name) on_this_processor(kernels::name##_baseline, kernels::name##_avx2, kernels::name##_avx512)
#else
#define PARADESC_DECLARE_TARGETS(Type, name)                                                                                     \
  namespace kernels {                                                                                                            \
  PARADESC_DECLARE_TARGET(Type, name, baseline)                                                                                  \
  }
#define PARADESC_ON_THIS_PROCESSOR(name) on_this_processor(kernels::name##_baseline)
#endif

namespace paradesc {

// Returns those that this processor can run, the widest first.
template <class Target>
std::vector<Target> on_this_processor(const Target &baseline
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

} // namespace paradesc
