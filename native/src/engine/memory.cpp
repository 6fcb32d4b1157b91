// The factors are those of `tests/bench/memory.py`, which prints how far a peak is from what is expected here.
#include "engine/memory.h"

#include <algorithm>

#include "descriptor/registry.h"

#include "shared.h"

namespace paradesc {

int64_t rows_of(std::span<const int> descriptors) {
  int64_t rows = ROW_DESCRIPTORS;
  for (const int descriptor : descriptors) rows += descriptor_row(descriptor).components;
  return rows;
}

int64_t bytes_of_results(const ComputationSize &size) {
  constexpr int64_t of_thread = 8; // for each triangle: SolidMeasure, FacetFlood
  const int64_t creases = size.options.creases == PDESC_CREASES_NONE ? 0 : 120 + size.threads * of_thread;
  // What operators work on is computed at the points of all pieces.
  const auto reads_map = [](int row) { return descriptor_row(row).needs != MapNeeds::nothing; };
  const int64_t points = std::ranges::any_of(size.descriptors, reads_map) ? size.piece_points : size.points;
  return (60 + creases) * size.triangles + 400 * size.points + 12 * rows_of(size.descriptors) * points;
}

} // namespace paradesc
