// The factors are those of `tests/bench/memory.py`, which prints how far a peak is from what is expected here.
#include "engine/memory.h"

#include "descriptor/registry.h"

#include "shared.h"

namespace paradesc {

int64_t rows_of(std::span<const int> descriptors) {
  int64_t rows = ROW_DESCRIPTORS;
  for (const int descriptor : descriptors) rows += descriptor_row(descriptor).components;
  return rows;
}

int64_t bytes_of_results(const ComputationSize &size) {
  const int64_t creases = size.options.creases == PDESC_CREASES_NONE ? 0 : 100; // of which threads keep some
  return (60 + creases) * size.triangles + 400 * size.points + 12 * rows_of(size.descriptors) * size.points;
}

} // namespace paradesc
