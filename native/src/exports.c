/* A shared library needs a source of its own; everything in it comes from paradesc_core. Compiling this one as C99 also
 * proves that the public header is C. */
#include "paradesc/paradesc.h"

typedef int paradesc_header_is_c99[PDESC_OK == 0 ? 1 : -1];
