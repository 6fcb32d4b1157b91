// The private thread that owns the OpenGL context and makes every OpenGL call; other threads post work to it and wait.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "engine/paper/gl_context.h"
#include "engine/paper/program.h"

namespace paradesc {

class GlThread {
public:
  GlThread(bool software, int device_index, const DriverSubstitute &substitute = {}); // throws as GlContext does
  ~GlThread();
  GlThread(const GlThread &) = delete;
  GlThread &operator=(const GlThread &) = delete;

  // Runs work on the thread, waits for it, and rethrows its exception. One caller at a time.
  void run(const std::function<void(const Gl &, ProgramCache &)> &work);
  const std::string &device() const { return device_; }
  int largest_dispatch() const { return largest_dispatch_; } // invocations of a list that one call may start
  int group_size() const { return group_size_; }             // invocations that a device runs together
  // Returns whether nothing more can be computed here, because some work ended with DEVICE_LOST or the thread is in another
  // process.
  bool lost() const { return shared_->lost || is_left_behind(); }
  // Returns whether this process was forked from the thread's own. Objects on the device must then be left as they are.
  bool is_left_behind() const;

private:
  // The state that callers share with the thread. A forked process must not touch it.
  struct Shared {
    std::mutex calls;
    std::mutex mutex;
    std::condition_variable changed;
    const std::function<void(const Gl &, ProgramCache &)> *work = nullptr;
    bool ready = false;
    bool stop = false;
    std::atomic<bool> lost = false;
    std::exception_ptr error;
    std::thread thread;
  };

  void loop(bool software, int device_index, const DriverSubstitute &substitute);

  std::unique_ptr<Shared> shared_ = std::make_unique<Shared>();
  std::string device_;
  int largest_dispatch_ = 0, group_size_ = 1;
  long process_;
};

} // namespace paradesc
