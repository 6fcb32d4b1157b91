// What engines that have no buffers answer.
#include "engine/engine.h"

namespace paradesc {

void refuse_to_read_buffers() {
  throw Error(PDESC_ERROR_INVALID_OPERATION,
              "This mesh has no baked buffers; compute on a backend other than the reference first.");
}

} // namespace paradesc
