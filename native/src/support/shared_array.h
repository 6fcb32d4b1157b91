// An immutable array that several values share.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace paradesc {

template <class T> class SharedArray {
public:
  SharedArray() = default;
  SharedArray(std::vector<T> values) : values_(std::make_shared<const std::vector<T>>(std::move(values))) {} // NOLINT: on purpose

  const T &operator[](size_t index) const { return (*values_)[index]; }
  size_t size() const { return values_ ? values_->size() : 0; }
  bool empty() const { return size() == 0; }
  const T *begin() const { return values_ ? values_->data() : nullptr; }
  const T *end() const { return begin() + size(); }
  std::vector<T> copy() const { return {begin(), end()}; }
  bool operator==(const SharedArray &other) const {
    return values_ == other.values_ || std::equal(begin(), end(), other.begin(), other.end());
  }

private:
  std::shared_ptr<const std::vector<T>> values_;
};

} // namespace paradesc
