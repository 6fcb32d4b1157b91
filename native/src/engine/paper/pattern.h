// Number of samples → their positions in the unit disk, and a rotation for each center.
#pragma once

#include <cstdint>
#include <vector>

#include "support/math.h"

namespace paradesc {

// Vogel's golden-angle set: every sample has the same area, and discrepancy is low at every count.
std::vector<vec2> golden_angle_pattern(int count);

// The paper's stratified set: a random position in each of `count` cells of equal area, mapped to the disk concentrically. If
// count is a square, the cells form a square grid; otherwise rows differ by one cell, and a row's height is proportional to its
// cells. Samples follow a snake through the rows, so even and odd ones are the two colors of a chessboard and each half is spread
// evenly.
std::vector<vec2> stratified_pattern(int count, uint32_t seed);

// Maps [-1, 1]^2 to the unit disk, preserving ratios of areas (Shirley and Chiu 1997).
dvec2 concentric_disk(dvec2 square);

// An angle in [0, 2 pi) by hashing a point's number and the seed: the same on every system.
float pattern_rotation(uint32_t point, uint32_t seed);

} // namespace paradesc
