// Loops over cores. Work is distributed in blocks of fixed size, so results do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>

#include "support/cancel.h"
#include "support/workers.h"

namespace paradesc {

inline int thread_count(int requested) {
  return requested > 0 ? requested : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

// The blocks into which [0, count) is cut, for any count that an int holds; the last block may be shorter.
struct Blocks {
  int count, size;
  int number() const { return static_cast<int>((int64_t{count} + size - 1) / size); }
  int begin(int block) const { return static_cast<int>(std::min(int64_t{block} * size, int64_t{count})); }
  int end(int block) const { return begin(block + 1); }
};

// Calls body(begin, end) for blocks of [0, count); the calling thread takes part. The first exception is rethrown after all
// threads have stopped. The caller may cancel between blocks, and while it waits for other threads' last blocks, which end at
// their next checkpoint.
template <class Body> void parallel_blocks(int count, int threads, int block, const Body &body) {
  const Blocks blocks{count, block};
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
      const int i = next.fetch_add(1);
      if (i >= blocks.number()) return;
      attempt([&] {
        checkpoint();
        body(blocks.begin(i), blocks.end(i));
      });
    }
  };
  {
    Workers::Loop loop(std::min(thread_count(threads), blocks.number()) - 1, work);
    work();
    constexpr std::chrono::milliseconds patience{10};
    while (!failed && !loop.wait(patience)) attempt(checkpoint);
  }
  if (error) std::rethrow_exception(error);
}

} // namespace paradesc
