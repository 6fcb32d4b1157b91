// A process that is forked from the test's: it must end by itself, and right.
#pragma once

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

#include <cstdio>
#include <functional>
#include <string>

#include <gtest/gtest.h>

namespace paradesc::test {

// wrong() runs in the child and says what is wrong there, "" if nothing is.
inline void expect_right_in_a_fork(const std::function<std::string()> &wrong) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(120); // a hang is a failure
    const std::string found = wrong();
    std::fputs(found.c_str(), stderr);
    _exit(found.empty() ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "it ended with " << status;
}

} // namespace paradesc::test
#endif
