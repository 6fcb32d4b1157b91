#include "support/percent_ae.h"

#include <algorithm>
#include <cmath>

namespace paradesc::test {
namespace {

// Linear between the two nearest ranks. values sorted, not empty.
double percentile(const std::vector<double> &values, double fraction) {
  const double rank = fraction * static_cast<double>(values.size() - 1);
  const size_t below = static_cast<size_t>(rank), above = std::min(below + 1, values.size() - 1);
  return values[below] + (rank - static_cast<double>(below)) * (values[above] - values[below]);
}

double denominator(std::span<const double> reference, double flat_scale) {
  std::vector<double> sorted;
  for (const double value : reference)
    if (std::isfinite(value)) sorted.push_back(value);
  if (sorted.empty()) return flat_scale;
  std::sort(sorted.begin(), sorted.end());
  const double largest = std::max(std::abs(sorted.front()), std::abs(sorted.back()));
  const double range = percentile(sorted, 0.975) - percentile(sorted, 0.025);
  if (range >= 1e-3 * largest && range > 1e-6 * flat_scale) return range;
  return largest > 1e-6 * flat_scale ? largest : flat_scale; // rounding alone is no magnitude
}

} // namespace

PercentAe percent_ae(std::span<const float> values, std::span<const double> reference, std::span<const uint8_t> subset,
                     double flat_scale) {
  PercentAe result;
  result.range = denominator(reference, flat_scale);
  std::vector<double> errors;
  for (size_t v = 0; v < values.size(); ++v) {
    if (!subset.empty() && !subset[v]) continue;
    const bool defined = std::isfinite(values[v]), expected = std::isfinite(reference[v]);
    if (!defined && !expected) continue;
    errors.push_back(defined && expected ? 100 * std::abs(static_cast<double>(values[v]) - reference[v]) / result.range : 100);
  }
  result.count = static_cast<int>(errors.size());
  if (errors.empty()) return result;
  std::sort(errors.begin(), errors.end());
  for (const double error : errors) result.mean += error / static_cast<double>(errors.size());
  result.median = percentile(errors, 0.5);
  result.p99 = percentile(errors, 0.99);
  result.max = errors.back();
  return result;
}

std::vector<double> as_double(std::span<const float> values) { return {values.begin(), values.end()}; }

std::vector<uint8_t> without(std::span<const uint8_t> a, std::span<const uint8_t> b) {
  std::vector<uint8_t> result(a.begin(), a.end());
  for (size_t i = 0; i < result.size(); ++i) result[i] = a[i] && !b[i];
  return result;
}

} // namespace paradesc::test
