// The factors agree with `tests/bench/memory.py`, which prints how far a peak is from this forecast.
#include "engine/memory.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "descriptor/registry.h"
#include "support/free_memory.h"

#include "shared.h"

namespace paradesc {

int64_t rows_of(std::span<const int> descriptors) {
  int64_t rows = ROW_DESCRIPTORS;
  for (const int descriptor : descriptors) rows += descriptor_row(descriptor).components;
  return rows;
}

static std::string in_words(int64_t bytes) {
  const auto number = static_cast<double>(bytes);
  char text[32];
  if (bytes < 10'000'000)
    std::snprintf(text, sizeof text, "%.0f kB", std::ceil(1e-3 * number));
  else if (bytes < 1'000'000'000)
    std::snprintf(text, sizeof text, "%.0f MB", std::ceil(1e-6 * number));
  else
    std::snprintf(text, sizeof text, "%.1f GB", 1e-9 * number);
  return text;
}

void check_memory(int64_t memory_limit, const std::string &subject, const std::string &remedy, int64_t needed, int64_t held) {
  constexpr int64_t little = 32'000'000; // asking the system for each frame of a small mesh takes too long
  if (memory_limit == 0 && needed <= little) return;
  const int64_t allowed = allowed_memory(memory_limit, held);
  if (needed <= allowed) return;
  const bool limited = memory_limit > 0;
  throw Error(PDESC_ERROR_OUT_OF_MEMORY, subject + " needs about " + in_words(needed) + " of memory, and " + in_words(allowed) +
                                             " may be used (" +
                                             (limited ? "what the memory limit leaves" : "half of what is free") + "); " +
                                             remedy + ", or " + (limited ? "set a higher limit." : "close other programs."));
}

} // namespace paradesc
