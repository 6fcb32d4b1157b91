// A caller's wish to stop reaches any depth of a long computation, on all of its threads, without a parameter through every
// function.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <thread>

namespace paradesc {

// The least time between two questions of this thread; tests set it to none, so that every checkpoint asks.
extern thread_local std::chrono::milliseconds cancel_patience;

// While it lives, checkpoint() on the thread that made it calls ask(), not more often than its patience says; ask throws where
// the caller says stop, and then checkpoint() throws on the other threads of the computation too. Scopes nest: while an inner one
// lives, it is the one that asks.
class CancelScope {
public:
  explicit CancelScope(std::function<void()> ask);
  ~CancelScope();
  CancelScope(const CancelScope &) = delete;
  CancelScope &operator=(const CancelScope &) = delete;

  static CancelScope *current(); // of this thread, or null

  // Has another thread take part in a scope; null: in none.
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

// Must be called where nothing is half done: it may throw. It costs next to nothing, and does nothing without a scope.
void checkpoint();

// In a loop: a checkpoint once in so many steps as take a few milliseconds at most.
inline void checkpoint_at(size_t step, size_t steps = 32768) {
  if (step % steps == 0) checkpoint();
}

} // namespace paradesc
