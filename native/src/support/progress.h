// Reports the progress of a computation to the caller, lets the caller cancel it, and measures how long its parts took.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "support/error.h"

namespace paradesc {

// progress(stage, fraction) returns false to cancel.
using Progress = std::function<bool(const char *stage, double fraction)>;

// The progress function of a caller of the C interface, which may have given none.
inline Progress progress_of(pdesc_progress function, void *user) {
  return [=](const char *stage, double fraction) { return !function || function(user, stage, fraction) != 0; };
}

// Throws Error(CANCELLED) if the caller cancels.
inline void check_cancel(const Progress &progress, const char *stage, double fraction) {
  if (!progress(stage, fraction)) throw Error(PDESC_ERROR_CANCELLED, std::string("Cancelled in stage ") + stage + ".");
}

class Clock {
public:
  // Seconds since the last lap, or since the clock was made.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace paradesc
