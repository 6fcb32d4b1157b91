// Refuses computations beyond the limit.
#pragma once

#include <string>

#include "engine/engine.h"

namespace paradesc {

// Rows of results at a center: coverage, flags, area, then one for each component of a descriptor.
int64_t rows_of(std::span<const int> descriptors);

// Throws Error(OUT_OF_MEMORY) with both numbers if more is needed than allowed. subject: "A mesh of 17 triangles"; remedy:
// "use fewer triangles".
void check_memory(int64_t memory_limit, const std::string &subject, const std::string &remedy, int64_t needed, int64_t held);

} // namespace paradesc
