// How tests make a driver fail.
#pragma once

#include <functional>

namespace paradesc {

// What takes the place of libEGL.so.1 or of an entry point of EGL or OpenGL, by its name. Empty in the library itself, and out of
// reach of its callers.
using DriverSubstitute = std::function<void *(const char *name, void *found)>;

} // namespace paradesc
