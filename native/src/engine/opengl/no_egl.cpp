// Stands in for egl_context.cpp on systems that have no EGL: there is never a device, and the reference computes.
#include "engine/opengl/egl_context.h"

#include "support/error.h"

namespace paradesc {

struct EglContext::Egl {};

EglContext::EglContext(bool, int, const DriverSubstitute &) {
  throw Error(PDESC_ERROR_UNSUPPORTED,
              "Graphics devices are used on Linux only, through EGL; use the reference backend, which computes the same slower.");
}

EglContext::~EglContext() = default;

void check_gl(const Gl &, const char *) {}

} // namespace paradesc
