// Loops over cores. Work is handed out in blocks of fixed size, so results do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "support/cancel.h"

namespace paradesc {

inline int thread_count(int requested) {
  return requested > 0 ? requested : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

// The threads of a loop beside its caller's, until all have ended.
class Team {
public:
  // Fewer than these if the system gives no more threads.
  template <class Work> void start(int count, const Work &work) {
    try {
      for (int i = 0; i < count; ++i) {
        threads_.emplace_back([this, &work] {
          work();
          const std::lock_guard lock(mutex_);
          ++ended_;
          change_.notify_one();
        });
      }
    } catch (const std::system_error &) {
    }
  }
  // Whether all have ended by then.
  bool wait(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return change_.wait_for(lock, patience, [&] { return ended_ == threads_.size(); });
  }

private:
  std::mutex mutex_;
  std::condition_variable change_;
  size_t ended_ = 0;
  std::vector<std::jthread> threads_;
};

// body(begin, end) for blocks of [0, count); the calling thread takes part. The first exception is thrown on after all have
// stopped. Between blocks the caller may cancel, and while it waits for the others' last ones, which end at their next
// checkpoint.
template <class Body> void parallel_blocks(int count, int threads, int block, const Body &body) {
  std::atomic<int> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr error;
  CancelScope *const scope = CancelScope::current();
  const auto attempt = [&](const auto &step) {
    try {
      step();
    } catch (...) {
      if (!failed.exchange(true)) error = std::current_exception();
    }
  };
  auto work = [&] {
    const CancelScope::Member member(scope);
    while (!failed) {
      const int begin = next.fetch_add(block);
      if (begin >= count || begin < 0) return;
      attempt([&] {
        checkpoint();
        body(begin, std::min(begin + block, count));
      });
    }
  };
  {
    Team team;
    team.start(std::min(thread_count(threads), (count + block - 1) / std::max(block, 1)) - 1, work);
    work();
    constexpr std::chrono::milliseconds patience{10};
    while (!failed && !team.wait(patience)) attempt(checkpoint);
  }
  if (error) std::rethrow_exception(error);
}

} // namespace paradesc
