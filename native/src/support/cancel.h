// Lets a caller cancel a long computation at any depth and on all of its threads, without passing a parameter through every
// function.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <thread>

namespace paradesc {

// The least time between two calls of ask() on this thread; tests set it to zero, so that every checkpoint asks.
extern thread_local std::chrono::milliseconds cancel_patience;

// While a scope lives, checkpoint() on the thread that made it calls ask(), at most as often as the patience allows. ask throws
// if the caller cancels, and then checkpoint() throws on the other threads of the computation, too. Scopes nest: the innermost
// one asks.
class CancelScope {
public:
  explicit CancelScope(std::function<void()> ask);
  ~CancelScope();
  CancelScope(const CancelScope &) = delete;
  CancelScope &operator=(const CancelScope &) = delete;

  static CancelScope *current(); // of this thread, or null

  // Makes another thread a member of a scope, or of none if it is null.
  class Member {
  public:
    explicit Member(CancelScope *scope);
    ~Member();
    Member(const Member &) = delete;
    Member &operator=(const Member &) = delete;

  private:
    CancelScope *before_;
  };

private:
  friend void checkpoint();
  void check();

  std::function<void()> ask_;
  std::thread::id owner_ = std::this_thread::get_id();
  std::chrono::steady_clock::time_point last_asked_ = std::chrono::steady_clock::now();
  std::atomic<bool> stopped_{false};
  Member member_{this};
};

// Must be called only where nothing is half done, because it may throw. It is nearly free, and does nothing without a scope.
void checkpoint();

// For loops: a checkpoint every `steps` steps, which should take a few milliseconds at most.
inline void checkpoint_at(size_t step, size_t steps = 32768) {
  if (step % steps == 0) checkpoint();
}

} // namespace paradesc
