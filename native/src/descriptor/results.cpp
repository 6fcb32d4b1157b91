// Results of some centers + those of others → one list.
#include "descriptor/results.h"

#include <algorithm>

namespace paradesc {

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
