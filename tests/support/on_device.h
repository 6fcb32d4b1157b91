// A private GL thread on the device, for tests below the C interface; skips where there is none.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "engine/paper/gl_thread.h"
#include "support/device.h"
#include "support/error.h"

namespace paradesc::test {

class OnDevice : public ::testing::Test {
protected:
  void SetUp() override {
    try {
      thread = std::make_unique<GlThread>(!on_card(), -1);
    } catch (const Error &error) {
      GTEST_SKIP() << error.what();
    }
  }
  std::unique_ptr<GlThread> thread;
};

} // namespace paradesc::test
