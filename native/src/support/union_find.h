// Items → sets of items that were joined.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace paradesc {

class UnionFind {
public:
  explicit UnionFind(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  // Returns the smallest item of the set of this one.
  int32_t root_of(int32_t item) {
    while (parent_[item] != item) item = parent_[item] = parent_[parent_[item]];
    return item;
  }
  void join(int32_t a, int32_t b) {
    const auto [low, high] = std::minmax({root_of(a), root_of(b)});
    parent_[high] = low;
  }

private:
  std::vector<int32_t> parent_;
};

} // namespace paradesc
