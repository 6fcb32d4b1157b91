// Claims that must hold whatever the input; one that does not aborts, which the fuzzer reports.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "paradesc/paradesc.h"

namespace paradesc::fuzz {

inline constexpr float sentinel = -12345.678f; // stands in outputs before a call
inline int64_t calls_made = 0;                   // those whose status was looked at, over all inputs

inline void claim(bool holds, const char *what) {
  if (holds) return;
  std::fprintf(stderr, "The interface broke its word: %s. Its last sentence: %s\n", what, pdesc_last_error());
  std::abort();
}

// A code of the header, with one sentence exactly where it is a failure. True on success.
inline bool done(int32_t status) {
  ++calls_made;
  claim(status >= PDESC_OK && status <= PDESC_ERROR_DEVICE_LOST, "a status is none of the header's");
  claim(status != PDESC_ERROR_UNKNOWN, "an input led to a defect of the library");
  const char *sentence = pdesc_last_error();
  claim((status == PDESC_OK) == (*sentence == 0), "a failure has no sentence, or a success has one");
  claim(status == PDESC_ERROR_UNSUPPORTED || !std::strchr(sentence, '\n'), "a sentence has several lines");
  return status == PDESC_OK;
}

} // namespace paradesc::fuzz
