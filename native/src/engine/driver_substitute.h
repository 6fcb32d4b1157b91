// How tests make a driver fail.
#pragma once

#include <functional>

namespace paradesc {

// Replaces libEGL.so.1 or an entry point of EGL or OpenGL, by its name. It is empty in the library itself, whose callers cannot
// set it.
using DriverSubstitute = std::function<void *(const char *name, void *found)>;

} // namespace paradesc
