// Number of samples → their places in the unit disk, and a rotation for each evaluation point.
#pragma once

#include <cstdint>
#include <vector>

#include "support/math.h"

namespace paradesc {

// Vogel's golden-angle set: equal areas, low discrepancy at every count.
std::vector<vec2> golden_angle_pattern(int count);

// An angle in [0, 2 pi) from a point's number and the seed: the same everywhere.
float pattern_rotation(uint32_t point, uint32_t seed);

} // namespace paradesc
