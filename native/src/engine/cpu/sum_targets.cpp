// The processor → the sums that are compiled for it.
#include "engine/cpu/add_samples.h"
#include "engine/cpu/ball_sums.h"
#include "engine/kernels/targets.h"

namespace paradesc {

PARADESC_DECLARE_TARGETS(SumTarget, sums_of)
PARADESC_DECLARE_TARGETS(BallTarget, ball_sums_of)

std::vector<SumTarget> sum_targets() { return PARADESC_ON_THIS_PROCESSOR(sums_of); }
std::vector<BallTarget> ball_targets() { return PARADESC_ON_THIS_PROCESSOR(ball_sums_of); }

} // namespace paradesc
