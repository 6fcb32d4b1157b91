// Values at the centers of evaluation (points or texels), before they are gathered to vertices.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace paradesc {

struct CenterResults {
  std::vector<std::vector<float>> values; // [descriptor][center, component], units of the positions
  double refined_share = 1.0;             // the share of the centers that took all samples
  std::vector<float> coverage;            // (centers) NaN at centers without a place in the UV map
  std::vector<uint8_t> boundary;          // (centers)
};

// Converts a value to another unit, whose factor may overflow or underflow a float even if the product does not. 0 stays 0.
inline float in_unit(float value, double unit) {
  const auto rounded = static_cast<float>(unit);
  return std::isnormal(rounded) ? value * rounded : static_cast<float>(value * unit);
}

// Returns NaN for each of `count` centers, with full coverage. rows: rows of the registry.
CenterResults unknown_results(size_t count, std::span<const int> rows);

// Keeps only the first `count` centers. rows: the registry rows of the values.
void keep_centers(CenterResults &results, size_t count, std::span<const int> rows);

// Converts values to the units of the positions. scale: units of the values per unit of the positions.
void scale_values(std::span<const int> rows, double scale, CenterResults &results);

} // namespace paradesc
