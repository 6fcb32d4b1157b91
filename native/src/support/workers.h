// Threads that wait for loops, so that loops need not start threads.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace paradesc {

// Workers serve one thread at a time. They are started when a loop first needs them.
class Workers {
public:
  Workers();
  ~Workers();
  Workers(const Workers &) = delete;
  Workers &operator=(const Workers &) = delete;

  // While a scope lives, loops of the thread that made it use these workers.
  class Scope {
  public:
    explicit Scope(Workers &workers);
    ~Scope();
    Scope(const Scope &) = delete;
    Scope &operator=(const Scope &) = delete;

  private:
    Workers *before_;
  };

  // One loop: up to `count` threads in addition to the caller run work(), which must not throw. The threads are those of the
  // scope; without a scope, and within another loop, they are started for this loop alone.
  class Loop {
  public:
    Loop(int count, const std::function<void()> &work);
    ~Loop(); // waits
    Loop(const Loop &) = delete;
    Loop &operator=(const Loop &) = delete;
    // Keeps threads that have not joined yet away. Returns whether all others have ended within the given time.
    bool wait(std::chrono::milliseconds patience);

  private:
    std::unique_ptr<Workers> own_;
    Workers *workers_ = nullptr; // null: nobody helps
  };

private:
  // The threads and their shared state.
  struct Call {
    std::vector<std::thread> threads;
    std::mutex mutex; // guards all that follows
    std::condition_variable called, ended;
    const std::function<void()> *work = nullptr;
    size_t wanted = 0, inside = 0;
    bool closing = false;
  };

  void start(size_t count);
  void leave_to_other_process();
  static void serve(Call &call);

  std::unique_ptr<Call> call_ = std::make_unique<Call>();
  long process_; // the process that the threads belong to
  bool in_use_ = false;
};

} // namespace paradesc
