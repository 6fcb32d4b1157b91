// Makes, shortens and joins results.
#include "descriptor/results.h"

#include <algorithm>
#include <numeric>

#include "descriptor/registry.h"

namespace paradesc {

CenterResults results_at_points(int point_count) {
  CenterResults results;
  results.point.resize(point_count);
  std::iota(results.point.begin(), results.point.end(), 0);
  results.primary.assign(point_count, 1);
  results.coverage.assign(point_count, 1.0f);
  return results;
}

void keep_centers(CenterResults &results, size_t count, std::span<const int> rows) {
  for (size_t k = 0; k < results.values.size(); ++k)
    results.values[k].resize(count * static_cast<size_t>(descriptor_row(rows[k]).components));
  results.point.resize(count);
  results.primary.resize(count);
  results.coverage.resize(count);
  results.boundary.resize(count);
}

void append(CenterResults &all, CenterResults &&part) {
  const auto add = [](auto &to, const auto &from) { to.insert(to.end(), from.begin(), from.end()); };
  const auto before = static_cast<double>(all.coverage.size()), more = static_cast<double>(part.coverage.size());
  all.refined_share = (all.refined_share * before + part.refined_share * more) / std::max(before + more, 1.0);
  all.values.resize(part.values.size());
  for (size_t i = 0; i < part.values.size(); ++i) add(all.values[i], part.values[i]);
  add(all.point, part.point);
  add(all.primary, part.primary);
  add(all.coverage, part.coverage);
  add(all.boundary, part.boundary);
}

} // namespace paradesc
