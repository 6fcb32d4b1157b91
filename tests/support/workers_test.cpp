// Loops over threads that stay, that are started for one loop, and that a forked process has lost.
#include "support/workers.h"

#include <atomic>
#include <new>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/fork.h"
#include "support/no_memory.h"
#include "support/parallel.h"

namespace paradesc::test {
namespace {

// How often each of so many items is visited.
std::vector<int> visits(int count) {
  std::vector<std::atomic<int>> visited(static_cast<size_t>(count));
  parallel_blocks(count, 4, 3, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) ++visited[static_cast<size_t>(i)];
  });
  return {visited.begin(), visited.end()};
}

TEST(Workers, many_loops_on_the_same_threads_visit_every_item_once) {
  Workers workers;
  const Workers::Scope scope(workers);
  for (int loop = 0; loop < 2000; ++loop) ASSERT_EQ(visits(loop % 50), std::vector<int>(static_cast<size_t>(loop % 50), 1));
}

TEST(Workers, a_loop_within_a_loop_visits_every_item_once) {
  Workers workers;
  const Workers::Scope scope(workers);
  std::atomic<int> right{0};
  parallel_blocks(40, 4, 1, [&](int, int) { right += visits(20) == std::vector<int>(20, 1); });
  EXPECT_EQ(right, 40);
}

TEST(Workers, an_exception_leaves_them_ready_for_the_next_loop) {
  Workers workers;
  const Workers::Scope scope(workers);
  for (int loop = 0; loop < 50; ++loop) {
    const auto fails = [](int begin, int) {
      if (begin == 7) throw std::runtime_error("seven");
    };
    EXPECT_THROW(parallel_blocks(100, 4, 1, fails), std::runtime_error);
    EXPECT_EQ(visits(30), std::vector<int>(30, 1));
  }
}

TEST(Workers, scopes_nest_as_calls_from_a_callback_do) {
  Workers outer, inner;
  const Workers::Scope scope(outer);
  {
    const Workers::Scope within(inner);
    EXPECT_EQ(visits(30), std::vector<int>(30, 1));
  }
  EXPECT_EQ(visits(30), std::vector<int>(30, 1));
}

// How many loops this thread has been in.
thread_local int loops_of_thread = 0;

// Two threads at once, of which the caller is one: how many loops the other one has been in.
int loops_of_helper() {
  std::atomic<int> arrived{0}, found{0};
  const auto owner = std::this_thread::get_id();
  parallel_blocks(2, 2, 1, [&](int, int) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
    if (std::this_thread::get_id() != owner) found = ++loops_of_thread;
  });
  return found;
}

TEST(Workers, without_memory_to_start_are_there_for_the_next_loop) {
  for (int allocations = 0; allocations < 12; ++allocations) { // of which the loop needs some, and its first thread
    Workers workers;
    const Workers::Scope scope(workers);
    int visited = 0;
    try {
      const WithoutMemory none(allocations);
      parallel_blocks(1000, 2, 1000, [&](int begin, int end) { visited += end - begin; });
      parallel_blocks(1000, 2, 500, [](int, int) {});
    } catch (const std::bad_alloc &) { // the loop itself had none
    }
    const int before = loops_of_helper();
    EXPECT_EQ(loops_of_helper(), before + 1) << "a fresh thread came, after " << allocations;
  }
}

#ifdef CAN_FORK
TEST(Workers, a_forked_process_starts_its_own_and_ends) {
  Workers workers;
  const Workers::Scope scope(workers);
  ASSERT_EQ(visits(100), std::vector<int>(100, 1));
  expect_right_in_a_fork([&] {
    bool right = visits(100) == std::vector<int>(100, 1);
    {
      Workers of_child;
      const Workers::Scope own(of_child);
      right = right && visits(100) == std::vector<int>(100, 1);
    }
    return right ? "" : "an item was not visited once";
  });
  EXPECT_EQ(visits(100), std::vector<int>(100, 1));
}
#endif

} // namespace
} // namespace paradesc::test
