// The system's process number.
#include "support/process.h"

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace paradesc {

long this_process() {
#if defined(__unix__) || defined(__APPLE__)
  return getpid();
#else
  return 0;
#endif
}

} // namespace paradesc
