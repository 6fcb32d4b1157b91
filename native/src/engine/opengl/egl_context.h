// A headless OpenGL 4.5 core context by EGL, current on the thread that makes it. libEGL is opened at first use.
#pragma once

#include <memory>
#include <string>

#include "engine/driver_substitute.h"
#include "engine/opengl/gl.h"

namespace paradesc {

class EglContext {
public:
  // software: true takes a software rasterizer, false a hardware device. device_index: among the devices of that kind, -1: the
  // first that works. Throws Error(UNSUPPORTED) with what was found and what to do.
  EglContext(bool software, int device_index, const DriverSubstitute &substitute = {});
  ~EglContext();
  EglContext(const EglContext &) = delete;
  EglContext &operator=(const EglContext &) = delete;

  const Gl &gl() const { return gl_; }
  const std::string &device() const { return device_; }

private:
  struct Egl;
  // Loads OpenGL's functions and looks at what the context can do; why it cannot be used, or "".
  std::string look_at_context(bool software);

  std::unique_ptr<Egl> egl_;
  Gl gl_;
  std::string device_;
};

} // namespace paradesc
