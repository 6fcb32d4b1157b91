// The progress of a loop over cores, step by step.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "support/error.h"

namespace paradesc {

// Tells the caller, on the caller's thread, how far all threads have come; says stop to all of them.
class Ticker {
public:
  Ticker(int count, const std::function<bool(double)> &progress) : count_(count), progress_(progress) {}
  void step() {
    const int done = ++done_;
    if (std::this_thread::get_id() == caller_ && progress_) {
      const auto now = std::chrono::steady_clock::now();
      if (now - last_ >= interval) {
        last_ = now;
        if (!progress_(static_cast<double>(done) / count_)) cancelled_ = true;
      }
    }
    if (cancelled_) throw Error(PDESC_ERROR_CANCELLED, "The computation was cancelled by its progress callback.");
  }

private:
  static constexpr auto interval = std::chrono::milliseconds(20);
  const int count_;
  const std::function<bool(double)> &progress_;
  const std::thread::id caller_ = std::this_thread::get_id();
  std::chrono::steady_clock::time_point last_{}; // long ago: the first step tells
  std::atomic<int> done_{0};
  std::atomic<bool> cancelled_{false};
};

} // namespace paradesc
