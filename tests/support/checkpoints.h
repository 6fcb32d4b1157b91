// Work, measured by how often a caller could have cancelled it.
#pragma once

#include <chrono>
#include <functional>
#include <utility>

#include "support/cancel.h"

namespace paradesc::test {

// Checkpoints of this thread.
inline int checkpoints_of(const std::function<void()> &work) {
  const auto patience = std::exchange(cancel_patience, std::chrono::milliseconds(0));
  int count = 0;
  {
    const CancelScope scope([&] { ++count; });
    work();
  }
  cancel_patience = patience;
  return count;
}

} // namespace paradesc::test
