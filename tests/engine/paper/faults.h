// A driver that fails where a test says so: functions that replace the entry points of OpenGL and of the system's library.
#pragma once

#include <map>
#include <string>

#include <gtest/gtest.h>

#include "context.h"
#include "engine/paper/gl_context.h"
#include "support/device.h"
#include "support/sentence.h"

namespace paradesc::test {

// Through which the system's devices are reached.
#if defined(_WIN32)
inline constexpr const char *driver_library = "opengl32.dll";
#else
inline constexpr const char *driver_library = "libEGL.so.1";
#endif

// By the name of an entry point, or the library's. Others are the driver's own.
class FailingDriver {
public:
  template <class Function> FailingDriver &put(const std::string &name, Function *function) {
    replaced_[name] = reinterpret_cast<void *>(function);
    return *this;
  }
  FailingDriver &without(const std::string &name) {
    replaced_[name] = nullptr;
    return *this;
  }
  operator DriverSubstitute() const {
    return [replaced = replaced_](const char *name, void *found) {
      const auto put = replaced.find(name);
      return put == replaced.end() ? found : put->second;
    };
  }

private:
  std::map<std::string, void *> replaced_;
};

// The words of the error if no device of the tests' kind is left.
inline const char *no_device() { return on_card() ? "No hardware OpenGL 4.5 device" : "No software OpenGL 4.5 device"; }

inline std::shared_ptr<paradesc::Context> open_device(const DriverSubstitute &driver) {
  pdesc_context_options requested;
  pdesc_context_options_init(&requested);
  requested.backend = device_backend();
  return make_context(requested, driver);
}

// Refused by name with this word in the sentence; under AUTO, which needs no device, it goes unnoticed.
inline void expect_refused(const DriverSubstitute &failing, const char *word) {
  try {
    open_device(failing);
    ADD_FAILURE() << "the device was taken: " << word;
  } catch (const Error &error) {
    EXPECT_EQ(error.status(), PDESC_ERROR_UNSUPPORTED);
    expect_one_sentence(error.what(), word);
  }
  pdesc_context_options requested;
  pdesc_context_options_init(&requested);
  requested.backend = PDESC_BACKEND_AUTO;
  const auto context = make_context(requested, failing);
  EXPECT_EQ(context->backend, PDESC_BACKEND_CPU);
}

} // namespace paradesc::test
