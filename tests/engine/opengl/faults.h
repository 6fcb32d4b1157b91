// A driver that fails where a test says so: functions that replace EGL's and OpenGL's entry points.
#pragma once

#include <map>
#include <string>

#include "engine/opengl/egl_context.h"

namespace paradesc::test {

// By the name of an entry point, or "libEGL.so.1". Others are the driver's own.
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

} // namespace paradesc::test
