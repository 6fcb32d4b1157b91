// Constant objects that are compiled once for each set of instructions → those that this processor can use.
#pragma once

#include <vector>

#include "support/instructions.h"

#define PARADESC_TEXT(name) #name
#define PARADESC_TEXT_OF(name) PARADESC_TEXT(name)
#define PARADESC_JOIN(a, b) a##b
#define PARADESC_JOINED(a, b) PARADESC_JOIN(a, b)

// Defines name_baseline, name_avx2 or name_avx512, in a file that is compiled for each set of instructions under the name
// KERNEL_TARGET; the initializer follows.
#define PARADESC_TARGET(Type, name)                                                                                              \
  extern const Type PARADESC_JOINED(name##_, KERNEL_TARGET);                                                                     \
  const Type PARADESC_JOINED(name##_, KERNEL_TARGET)
#define PARADESC_TARGET_NAME PARADESC_TEXT_OF(KERNEL_TARGET)

// Defines a function that returns those that this processor can use, the widest first.
#if defined(__x86_64__)
#define PARADESC_TARGETS(Type, name, function)                                                                                   \
  extern const Type name##_baseline, name##_avx2, name##_avx512;                                                                 \
  std::vector<Type> function() {                                                                                                 \
    const Instructions widest = widest_instructions();                                                                           \
    if (widest == Instructions::avx512) return {name##_avx512, name##_avx2, name##_baseline};                                    \
    if (widest == Instructions::avx2) return {name##_avx2, name##_baseline};                                                     \
    return {name##_baseline};                                                                                                    \
  }
#else
#define PARADESC_TARGETS(Type, name, function)                                                                                   \
  extern const Type name##_baseline;                                                                                             \
  std::vector<Type> function() { return {name##_baseline}; }
#endif
