// Number of samples → their positions in the unit disk, and a rotation for each center.
#pragma once

#include <cstdint>
#include <vector>

#include "support/math.h"

namespace paradesc {

// Vogel's golden-angle set: equal areas, low discrepancy at every count.
std::vector<vec2> golden_angle_pattern(int count);

// The paper's stratified set: a random position in each of `count` cells of one area, mapped to the disk concentrically. The
// cells are those of a square grid where count is a square; else rows that differ by one cell, and are as high as they have
// cells. They come in the order of a snake through the rows: even and odd numbers are the two colors of a chessboard, so that
// either half is spread evenly.
std::vector<vec2> stratified_pattern(int count, uint32_t seed);

// Maps [-1, 1]^2 to the unit disk, areas in proportion (Shirley and Chiu 1997).
dvec2 concentric_disk(dvec2 square);

// An angle in [0, 2 pi) from a point's number and the seed: the same everywhere.
float pattern_rotation(uint32_t point, uint32_t seed);

} // namespace paradesc
