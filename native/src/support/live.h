// The set of live handles: a handle that was destroyed, or is of another kind, is refused instead of read.
#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>

namespace paradesc {

// The library's only global state, because a destroyed handle cannot report that itself. If a new handle of the same kind reuses
// the address, the old handle counts as the new one.
class LiveHandles {
public:
  template <class Handle> Handle *add(std::unique_ptr<Handle> handle) {
    const std::lock_guard lock(mutex_);
    kinds_.emplace(handle.get(), &kind<Handle>);
    return handle.release();
  }

  template <class Handle> bool contains(const Handle *handle) const {
    const std::lock_guard lock(mutex_);
    const auto found = kinds_.find(handle);
    return found != kinds_.end() && found->second == &kind<Handle>;
  }

  // Returns true to the one caller that may delete the handle.
  template <class Handle> bool remove(const Handle *handle) {
    const std::lock_guard lock(mutex_);
    const auto found = kinds_.find(handle);
    if (found == kinds_.end() || found->second != &kind<Handle>) return false;
    kinds_.erase(found);
    return true;
  }

private:
  template <class Handle> static constexpr char kind = 0; // its address stands for the type

  mutable std::mutex mutex_;
  std::unordered_map<const void *, const char *> kinds_;
};

} // namespace paradesc
