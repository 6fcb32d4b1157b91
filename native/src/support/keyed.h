// The value of one stage, stored with the key of everything that it was made from.
#pragma once

#include <optional>
#include <utility>

namespace paradesc {

// A value is valid for its key alone. While it is being made, or if making it throws, no value is stored, because a computation
// may be cancelled at any time.
template <class Key, class Value> class Keyed {
public:
  // Returns the value for this key; calls make() unless that value is stored already.
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
