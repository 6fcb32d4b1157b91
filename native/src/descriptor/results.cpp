// Makes and shortens results, and converts their units.
#include "descriptor/results.h"

#include <cstdlib>
#include <limits>

#include "descriptor/registry.h"
#include "support/cancel.h"

namespace paradesc {

CenterResults unknown_results(size_t count, std::span<const int> rows) {
  CenterResults results;
  results.coverage.assign(count, 1.0f);
  checkpoint();
  for (const int row : rows)
    results.values.emplace_back(count * static_cast<size_t>(descriptor_row(row).components),
                                std::numeric_limits<float>::quiet_NaN());
  results.boundary.assign(count, 0);
  return results;
}

void keep_centers(CenterResults &results, size_t count, std::span<const int> rows) {
  for (size_t k = 0; k < results.values.size(); ++k)
    results.values[k].resize(count * static_cast<size_t>(descriptor_row(rows[k]).components));
  results.coverage.resize(count);
  results.boundary.resize(count);
}

// Uses products only, whose results have the same bits on all machines.
static double power(double base, int exponent) {
  double product = 1.0;
  for (int k = 0; k < std::abs(exponent); ++k) product *= base;
  return exponent < 0 ? 1.0 / product : product;
}

void scale_values(std::span<const int> rows, double scale, CenterResults &results) {
  for (size_t k = 0; k < rows.size(); ++k) {
    const int exponent = -descriptor_row(rows[k]).length_power;
    if (exponent == 0) continue;
    const double unit = power(scale, exponent);
    for (float &value : results.values[k]) value = in_unit(value, unit);
  }
}

} // namespace paradesc
