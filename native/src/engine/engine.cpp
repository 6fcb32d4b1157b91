// The answers of engines without buffers.
#include "engine/engine.h"

namespace paradesc {

void refuse_to_read_buffers() {
  throw Error(
      PDESC_ERROR_INVALID_OPERATION,
      "This mesh has no baked buffers; compute in texture space first: with buffers = 1, on the backend auto, gpu or software.");
}

} // namespace paradesc
