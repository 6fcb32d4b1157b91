// Objects that threads use in turn: costly to make, and reusable without cleaning.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace paradesc {

template <class T> class Pool {
public:
  // Calls use(object) with an object that no thread is using, or else with a new one from make(). If the call throws, the object
  // is discarded.
  template <class Make, class Use> void with_one(const Make &make, const Use &use) {
    std::unique_ptr<T> one = take();
    if (!one) one = std::make_unique<T>(make());
    use(*one);
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(one));
  }

private:
  std::unique_ptr<T> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return nullptr;
    std::unique_ptr<T> one = std::move(idle_.back());
    idle_.pop_back();
    return one;
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> idle_;
};

} // namespace paradesc
