// The processor → the sums over faces that are compiled for it.
#include "engine/creases/face_sums.h"
#include "engine/kernels/targets.h"

namespace paradesc {

PARADESC_DECLARE_TARGETS(FaceTarget, face_sums_of)

std::vector<FaceTarget> face_targets() { return PARADESC_ON_THIS_PROCESSOR(face_sums_of); }

} // namespace paradesc
