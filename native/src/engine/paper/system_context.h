// The part that differs by system: the OpenGL library, places where a device may be, and a current context on one of them.
// CMake chooses egl_context.cpp (Linux), wgl_context.cpp (Windows) or no_context.cpp.
#pragma once

#include <memory>
#include <string>

#include "engine/driver_substitute.h"

namespace paradesc {

class SystemContext {
public:
  // Opens the library by name, so that nothing links it and ours also loads on systems without it. Throws Error(UNSUPPORTED).
  explicit SystemContext(const DriverSubstitute &substitute);
  ~SystemContext();
  SystemContext(const SystemContext &) = delete;
  SystemContext &operator=(const SystemContext &) = delete;

  // Lists devices of the kind, then those that may be of either kind; returns their number.
  int list_devices(bool software);
  // Makes a context of the device current: OpenGL 4.5 core if the device has it, else what it offers. The context shares nothing
  // with others. If the driver offers it, memory accesses of shaders are bounded and resets are reported. False leaves nothing
  // behind.
  bool make_current(int device);
  void drop();
  // OpenGL's function of that name, or a test's substitute for it. Requires a current context.
  void *function(const char *name) const;

  // Why a device of this name is not used on this system, or "".
  static std::string flaw_of(const std::string &device);
  static const char *library();         // its name in sentences
  static const char *software_advice(); // what to do for a software device

private:
  struct System;
  std::unique_ptr<System> system_;
};

// Returns whether a list of words, which may be nullptr, contains `name`.
inline bool has_extension(const char *list, const char *name) {
  const std::string padded = std::string(" ") + (list ? list : "") + " ";
  return padded.find(std::string(" ") + name + " ") != std::string::npos;
}

} // namespace paradesc
