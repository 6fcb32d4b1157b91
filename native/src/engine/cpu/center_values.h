// Values at centers, before anything is computed and in the units of the positions.
#pragma once

#include <span>

#include "descriptor/results.h"

namespace paradesc {

// NaN at so many centers. rows: of the registry.
CenterResults unknown_results(size_t count, std::span<const int> rows);

// scale: units that the values are in per unit of the positions.
void scale_values(std::span<const int> rows, double scale, CenterResults &results);

} // namespace paradesc
