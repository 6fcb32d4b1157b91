// Sorts centers by cell.
#include "sample/starts.h"

#include <algorithm>
#include <numeric>

namespace paradesc {

Starts list_starts(std::span<const int32_t> begin, std::span<const int32_t> start_cells, int cell_count) {
  constexpr int32_t longest = 4096; // one invocation visits all centers of a list (MAX_ITERATIONS in shared.h)
  const size_t centers = begin.size() - 1, count = static_cast<size_t>(cell_count);
  const auto cell_of = [&](size_t i) { return begin[i] < begin[i + 1] ? static_cast<size_t>(start_cells[begin[i]]) : count; };
  std::vector<int32_t> first(count + 2, 0); // first center of each cell
  for (size_t i = 0; i < centers; ++i) ++first[cell_of(i) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<int32_t> next(first.begin(), first.end() - 1);
  Starts starts;
  starts.order.resize(centers);
  for (size_t i = 0; i < centers; ++i) starts.order[next[cell_of(i)]++] = static_cast<int32_t>(i);
  starts.range.reserve(centers);
  for (const int32_t i : starts.order) starts.range.emplace_back(begin[i], begin[i + 1]);
  starts.cell.reserve(start_cells.size());
  for (const int32_t cell : start_cells) starts.cell.emplace_back(cell, 0);
  for (size_t cell = 0; cell < count; ++cell)
    for (int32_t from = first[cell], to = from; from < first[cell + 1]; from = to) {
      to = std::min(from + longest, first[cell + 1]);
      for (int32_t i = from; i < to; ++i) starts.cell[starts.range[i].x].y = static_cast<int32_t>(starts.list.size());
      starts.list.emplace_back(from, to);
    }
  return starts;
}

} // namespace paradesc
