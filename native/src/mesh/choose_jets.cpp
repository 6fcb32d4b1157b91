// Selects the jet fit compiled for the widest instructions of this processor.
#include "mesh/jets.h"
#include "support/instructions.h"

namespace paradesc {

#define DECLARE_TARGET(target)                                                                                                   \
  namespace target {                                                                                                             \
  extern const FitGradients gradients_of_this;                                                                                   \
  }
DECLARE_TARGET(baseline)
#if defined(__x86_64__)
DECLARE_TARGET(avx2)
DECLARE_TARGET(avx512)
#endif

FitGradients fit_gradients() {
#if defined(__x86_64__)
  const Instructions widest = widest_instructions();
  if (widest == Instructions::avx512) return avx512::gradients_of_this;
  if (widest == Instructions::avx2) return avx2::gradients_of_this;
#endif
  return baseline::gradients_of_this;
}

} // namespace paradesc
