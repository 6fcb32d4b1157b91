// Replaces egl_context.cpp and wgl_context.cpp on systems whose OpenGL is not used: there is never a device, and the processor
// computes. macOS ends at OpenGL 4.1. On Windows on ARM the only driver of OpenGL 4.5 is Mesa's over Direct3D 12, which crashed
// Blender itself on some of these machines.
#include "engine/paper/system_context.h"

#include "support/error.h"

namespace paradesc {

struct SystemContext::System {};

SystemContext::SystemContext(const DriverSubstitute &) {
  throw Error(PDESC_ERROR_UNSUPPORTED,
              "Graphics devices are used on Linux, and on Windows with an x86-64 processor, only; use the cpu backend.");
}

SystemContext::~SystemContext() = default;

int SystemContext::list_devices(bool) { return 0; }
bool SystemContext::make_current(int) { return false; }
void SystemContext::drop() {}
void *SystemContext::function(const char *) const { return nullptr; }
std::string SystemContext::flaw_of(const std::string &) { return ""; }
const char *SystemContext::library() { return "OpenGL"; }
const char *SystemContext::software_advice() { return "there is none here"; }

} // namespace paradesc
