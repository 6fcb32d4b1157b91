// What each system has of its own: its library, the places where it may have a device, and a current context at one of them.
// CMake chooses egl_context.cpp (Linux), wgl_context.cpp (Windows) or no_context.cpp.
#pragma once

#include <memory>
#include <string>

#include "engine/driver_substitute.h"

namespace paradesc {

class SystemContext {
public:
  // Opens the library by its name, so that nothing links it and ours loads where there is none. Throws Error(UNSUPPORTED).
  explicit SystemContext(const DriverSubstitute &substitute);
  ~SystemContext();
  SystemContext(const SystemContext &) = delete;
  SystemContext &operator=(const SystemContext &) = delete;

  // Looks for devices of the kind, then for such as may be of either; how many there are.
  int list_devices(bool software);
  // Makes a context of the device current, which shares nothing with any other: OpenGL 4.5 core, else what the device has. It
  // bounds what shaders reach and says when the device was reset, where that is offered. False leaves nothing behind.
  bool make_current(int device);
  void drop();
  // OpenGL's function of that name, or the one that a test puts in its place. Only while a context is current.
  void *function(const char *name) const;

  // Why a device of this name counts as none on this system, or "".
  static std::string flaw_of(const std::string &device);
  static const char *library();         // as sentences name it
  static const char *software_advice(); // what to do for a software device

private:
  struct System;
  std::unique_ptr<System> system_;
};

// Whether a list of words, or nullptr, has this one.
inline bool has_extension(const char *list, const char *name) {
  const std::string padded = std::string(" ") + (list ? list : "") + " ";
  return padded.find(std::string(" ") + name + " ") != std::string::npos;
}

} // namespace paradesc
