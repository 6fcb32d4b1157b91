// The value of one stage, kept under the key of all that it was made from.
#pragma once

#include <optional>
#include <utility>

namespace paradesc {

// A value is valid for its key alone. While it is made, and after making it has thrown, none is kept: a computation may be
// cancelled at any time.
template <class Key, class Value> class Keyed {
public:
  // The value for this key; make() returns it unless it is kept already.
  template <class Make> const Value &get(const Key &key, const Make &make) {
    if (key_ == key) return value_;
    clear();
    value_ = make();
    key_ = key;
    return value_;
  }
  const Value *find(const Key &key) const { return key_ == key ? &value_ : nullptr; }
  const std::optional<Key> &key() const { return key_; }
  const Value &value() const { return value_; } // of key()
  void clear() {
    key_.reset();
    value_ = {};
  }

private:
  std::optional<Key> key_;
  Value value_{};
};

} // namespace paradesc
