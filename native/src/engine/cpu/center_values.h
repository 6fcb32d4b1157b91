// Creates the values at centers before they are computed, and converts their units.
#pragma once

#include <span>

#include "descriptor/results.h"

namespace paradesc {

// Returns NaN for each of `count` centers. rows: rows of the registry.
CenterResults unknown_results(size_t count, std::span<const int> rows);

// Converts values to the units of the positions. scale: units of the values per unit of the positions.
void scale_values(std::span<const int> rows, double scale, CenterResults &results);

} // namespace paradesc
