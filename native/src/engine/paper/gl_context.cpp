// A system's context → OpenGL's functions, and a check that they and the device's limits are those of OpenGL 4.5. The first flaw
// is reported in one sentence.
#include "engine/paper/gl_context.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <type_traits>

#include "support/error.h"
#include "support/math.h"
#include "support/process.h"

#include "shared.h"

namespace paradesc {

static bool is_software_renderer(const std::string &name) {
  for (const char *known : {"llvmpipe", "softpipe", "swrast", "SWR", "SwiftShader"})
    if (name.find(known) != std::string::npos) return true;
  return false;
}

// A driver that reports less than OpenGL 4.5 promises is refused; larger reported limits are trusted until they fail.
static std::string read_limits(Gl &gl) {
  struct Promise {
    const char *name;
    GLint64 found, least;
  };
  GlLimits &limits = gl.limits;
  GLint bindings = 0, images = 0;
  limits.texture_size = limits.list_texels = limits.work_groups = 0;
  limits.storage_bytes = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &limits.texture_size);
  gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limits.list_texels);
  gl.GetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &limits.work_groups);
  gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limits.storage_bytes);
  gl.GetIntegerv(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, &bindings);
  gl.GetIntegerv(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS, &images);
  const Promise promises[] = {{"texels along a side of a texture", limits.texture_size, 16384},
                              {"texels of a buffer texture", limits.list_texels, 65536},
                              {"work groups", limits.work_groups, 65535},
                              {"bytes of a storage buffer", limits.storage_bytes, 1 << 27},
                              {"storage buffers", bindings, BINDING_COUNT},
                              {"textures", images, UNIT_COUNT}};
  for (const Promise &promise : promises)
    if (promise.found < promise.least)
      return "it takes " + std::to_string(promise.found) + " " + promise.name + ", and " + std::to_string(promise.least) +
             " are needed";
  return "";
}

std::string GlContext::look_at_context(bool software) {
  std::string missing;
  auto load = [&](const char *name, auto &function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(system_.function(name));
    if (!function && missing.empty()) missing = name;
  };
#define PARADESC_LOAD(type, name) load("gl" #name, gl_.name);
  PARADESC_GL_FUNCTIONS(PARADESC_LOAD)
#undef PARADESC_LOAD
  if (!gl_.GetString || !gl_.GetIntegerv) return "its driver has no glGetString";
  const auto *name = reinterpret_cast<const char *>(gl_.GetString(GL_RENDERER));
  device_ = name ? name : "a device without a name";
  if (const std::string flaw = SystemContext::flaw_of(device_); !flaw.empty()) return flaw;
  if (is_software_renderer(device_) != software) return software ? "it is hardware" : "it is a software rasterizer";
  GLint major = 0, minor = 0;
  gl_.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl_.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (10 * major + minor < 45) return "it offers OpenGL " + std::to_string(major) + "." + std::to_string(minor);
  if (!missing.empty()) return "its driver has no " + missing;
  const std::string flaw = read_limits(gl_);
  gl_.limits.group_size = software ? 16 : 64;
  // llvmpipe reports 2^27 bytes and accepts more; a test reads the end of a longer buffer.
  if (software) gl_.limits.storage_bytes = std::numeric_limits<GLint64>::max();
  return flaw;
}

// Throws if there is no device of that index.
static void check_index(int device_index, int count) {
  if (device_index < count) return;
  throw Error(PDESC_ERROR_UNSUPPORTED, "Device " + std::to_string(device_index) + " was asked for, but there " +
                                           (count == 1 ? "is" : "are") + " only " + std::to_string(count) +
                                           "; choose a lower index or -1.");
}

// Drivers keep threads for their whole process. A forked process has the driver's state without these threads, and would wait for
// them forever.
static void refuse_after_fork() {
  static std::atomic<long> opened_in = 0;
  long other = 0;
  if (opened_in.compare_exchange_strong(other, this_process()) || other == this_process()) return;
  throw Error(PDESC_ERROR_UNSUPPORTED,
              "OpenGL was open in the process that this one was forked from, which no driver follows; start "
              "processes by spawn, or use the cpu backend.");
}

GlContext::GlContext(bool software, int device_index, const DriverSubstitute &substitute) : system_(substitute) {
  refuse_after_fork();
  const int count = system_.list_devices(software);
  check_index(device_index, count);
  const int first = std::max(device_index, 0), end = device_index < 0 ? count : device_index + 1;
  std::string refused; // the last refused device of the requested kind
  for (int device = first; device < end; ++device) {
    if (!system_.make_current(device)) continue;
    const std::string flaw = look_at_context(software);
    if (flaw.empty()) return;
    if (!flaw.starts_with("it is ")) refused = " (" + (device_.empty() ? "a device" : device_) + " was left out: " + flaw + ")";
    system_.drop();
  }
  const std::string found = " OpenGL 4.5 device was found by " + std::string(SystemContext::library()) + refused + "; ";
  throw Error(PDESC_ERROR_UNSUPPORTED,
              software ? "No software" + found + SystemContext::software_advice() + ", or use the cpu backend."
                       : "No hardware" + found + "install its driver, or use the cpu or software backend.");
}

void check_gl(const Gl &gl, const char *stage) {
  const bool reset = gl.GetGraphicsResetStatus() != GL_NO_ERROR;
  const GLenum code = reset ? GL_CONTEXT_LOST : gl.GetError();
  if (code == GL_NO_ERROR) return;
  for (int i = 0; i < 64 && gl.GetError() != GL_NO_ERROR; ++i) // a lost context may repeat its error for ever
    ;
  if (code == GL_CONTEXT_LOST)
    throw Error(PDESC_ERROR_DEVICE_LOST, std::string("The graphics device was lost in stage ") + stage +
                                             ", because its driver had to be started again; try again with smaller buffers, or "
                                             "use another backend.");
  if (code == GL_OUT_OF_MEMORY)
    throw Error(PDESC_ERROR_OUT_OF_MEMORY, std::string("The graphics device ran out of memory in stage ") + stage +
                                               "; use smaller buffers, or another backend.");
  throw Error(PDESC_ERROR_UNKNOWN, std::string("OpenGL error ") + std::to_string(code) + " in stage " + stage +
                                       "; please report it with the device's name, and use the cpu backend meanwhile.");
}

} // namespace paradesc
