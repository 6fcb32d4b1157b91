// Loops over cores. Work is handed out in blocks of fixed size, so results do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

#include "support/cancel.h"

namespace paradesc {

inline int thread_count(int requested) {
  return requested > 0 ? requested : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

// body(begin, end) for blocks of [0, count); the calling thread takes part. The first exception is thrown on after all have
// stopped. Between blocks the caller may cancel.
template <class Body> void parallel_blocks(int count, int threads, int block, const Body &body) {
  std::atomic<int> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr error;
  CancelScope *const scope = CancelScope::current();
  auto work = [&] {
    const CancelScope::Member member(scope);
    while (!failed) {
      const int begin = next.fetch_add(block);
      if (begin >= count || begin < 0) return;
      try {
        checkpoint();
        body(begin, std::min(begin + block, count));
      } catch (...) {
        if (!failed.exchange(true)) error = std::current_exception();
      }
    }
  };
  std::vector<std::jthread> team;
  const int helpers = std::min(thread_count(threads), (count + block - 1) / std::max(block, 1)) - 1;
  try {
    for (int i = 0; i < helpers; ++i) team.emplace_back(work);
  } catch (const std::system_error &) {
    // The system gives no more threads: those that there are do the work.
  }
  work();
  team.clear();
  if (error) std::rethrow_exception(error);
}

} // namespace paradesc
