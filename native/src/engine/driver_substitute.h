// Lets tests make a driver fail.
#pragma once

#include <functional>

namespace paradesc {

// Replaces a library of the system (libEGL.so.1, opengl32.dll), or one of its or OpenGL's entry points, by name. The library
// itself leaves it empty, and its callers cannot set it.
using DriverSubstitute = std::function<void *(const char *name, void *found)>;

} // namespace paradesc
