// Loops over threads that stay, that are started for one loop, and that a forked process has lost.
#include "support/workers.h"

#include <atomic>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "support/parallel.h"

// ThreadSanitizer knows no threads after a fork.
#if defined(__has_feature)
#define IS_THREAD_SANITIZED __has_feature(thread_sanitizer)
#elif defined(__SANITIZE_THREAD__)
#define IS_THREAD_SANITIZED 1
#else
#define IS_THREAD_SANITIZED 0
#endif
#if defined(__unix__) && !IS_THREAD_SANITIZED
#define CAN_FORK
#include <sys/wait.h>
#include <unistd.h>
#endif

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

#ifdef CAN_FORK
TEST(Workers, a_forked_process_starts_its_own_and_ends) {
  Workers workers;
  const Workers::Scope scope(workers);
  ASSERT_EQ(visits(100), std::vector<int>(100, 1));
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(20); // a hang is a failure
    bool right = visits(100) == std::vector<int>(100, 1);
    {
      Workers of_child;
      const Workers::Scope own(of_child);
      right = right && visits(100) == std::vector<int>(100, 1);
    }
    _exit(right ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(visits(100), std::vector<int>(100, 1));
}
#endif

} // namespace
} // namespace paradesc::test
