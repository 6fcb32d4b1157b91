// Objects that threads take turns with: what is costly to make, and clean after use.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace paradesc {

template <class T> class Pool {
public:
  // use(object), with one that no thread uses at the moment, or with what make() returns. One that throws meanwhile is not used
  // again.
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
