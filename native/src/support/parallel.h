// Loops over cores. Work is handed out in blocks of fixed size, so results do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <thread>

#include "support/cancel.h"
#include "support/workers.h"

namespace paradesc {

inline int thread_count(int requested) {
  return requested > 0 ? requested : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

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
  const std::function<void()> work = [&] {
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
    Workers::Loop loop(std::min(thread_count(threads), (count + block - 1) / std::max(block, 1)) - 1, work);
    work();
    constexpr std::chrono::milliseconds patience{10};
    while (!failed && !loop.wait(patience)) attempt(checkpoint);
  }
  if (error) std::rethrow_exception(error);
}

} // namespace paradesc
