// How tests make a driver fail.
#pragma once

#include <functional>

namespace paradesc {

// Replaces a library of the system (libEGL.so.1, opengl32.dll) or an entry point of it or of OpenGL, by its name. It is empty in
// the library itself, whose callers cannot set it.
using DriverSubstitute = std::function<void *(const char *name, void *found)>;

} // namespace paradesc
