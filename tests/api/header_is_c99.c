/* The public header compiles as C99, and its calls can be made from C. */
#include "paradesc/paradesc.h"

int32_t header_is_c99(void);

int32_t header_is_c99(void) {
  pdesc_options options;
  pdesc_options_init(&options);
  return options.samples > 0 ? pdesc_abi_version() : 0;
}
