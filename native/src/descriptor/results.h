// Values at the centers of evaluation (wedges, texels, or points of the reference), before they are gathered to vertices.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace paradesc {

struct CenterResults {
  std::vector<int32_t> point;             // (centers) point evaluated
  std::vector<uint8_t> primary;           // (centers) 1: the center whose values the point takes
  std::vector<std::vector<float>> values; // [descriptor][center, component], units of the positions
  double refined_share = 1.0;             // the share of the centers that took all samples
  std::vector<float> coverage;            // (centers)
  std::vector<uint8_t> boundary;          // (centers)
};

// Converts a value to another unit, whose factor may overflow or underflow a float even if the product does not. 0 stays 0.
inline float in_unit(float value, double unit) {
  const auto rounded = static_cast<float>(unit);
  return std::isnormal(rounded) ? value * rounded : static_cast<float>(value * unit);
}

// Results with each point as its own only center and full coverage. The caller fills in values and boundary.
CenterResults results_at_points(int point_count);

// Keeps only the first `count` centers. rows: the registry rows of the values.
void keep_centers(CenterResults &results, size_t count, std::span<const int> rows);

// Appends the results of further centers.
void append(CenterResults &all, CenterResults &&part);

} // namespace paradesc
