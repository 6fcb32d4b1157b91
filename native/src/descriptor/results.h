// Values at the centers of evaluation (wedges, texels, or points of the reference), before they go to vertices or texels.
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

// A value in another unit, which may be beyond what a float holds where the value is not: 0 stays 0.
inline float in_unit(float value, double unit) {
  const auto rounded = static_cast<float>(unit);
  return std::isnormal(rounded) ? value * rounded : static_cast<float>(value * unit);
}

// Results of every point as its own only center, all of whose surface was found; values and boundary are left to the caller.
CenterResults results_at_points(int point_count);

// Leaves the first ones. rows: of the registry, that the values are of.
void keep_centers(CenterResults &results, size_t count, std::span<const int> rows);

// Adds the results of further centers.
void append(CenterResults &all, CenterResults &&part);

} // namespace paradesc
