// An OpenGL 4.5 core context without a visible window, current on the thread that makes it.
#pragma once

#include <string>

#include "engine/driver_substitute.h"
#include "engine/paper/gl.h"
#include "engine/paper/system_context.h"

namespace paradesc {

class GlContext {
public:
  // software: true takes a software rasterizer, false a hardware device. device_index: among the devices of that kind; -1: the
  // first that works. Throws Error(UNSUPPORTED) that says what was found and what to do.
  GlContext(bool software, int device_index, const DriverSubstitute &substitute = {});

  const Gl &gl() const { return gl_; }
  const std::string &device() const { return device_; }

private:
  // Loads OpenGL's functions and checks the context; returns why it cannot be used, or "".
  std::string look_at_context(bool software);

  SystemContext system_;
  Gl gl_;
  std::string device_;
};

} // namespace paradesc
