// libEGL, opened at run time → a current OpenGL 4.5 core context without a window.
#include "gpu/egl_context.h"

#define EGL_NO_X11
#define MESA_EGL_NO_X11_HEADERS
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <cstring>
#include <vector>

#include "support/error.h"

namespace paradesc {

struct EglContext::Egl {
  void *library = nullptr;
  PFNEGLGETPROCADDRESSPROC get_proc_address = nullptr;
  PFNEGLQUERYSTRINGPROC query_string = nullptr;
  PFNEGLINITIALIZEPROC initialize = nullptr;
  PFNEGLBINDAPIPROC bind_api = nullptr;
  PFNEGLCREATECONTEXTPROC create_context = nullptr;
  PFNEGLDESTROYCONTEXTPROC destroy_context = nullptr;
  PFNEGLMAKECURRENTPROC make_current = nullptr;
  PFNEGLRELEASETHREADPROC release_thread = nullptr;
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;
  PFNEGLQUERYDEVICESTRINGEXTPROC query_device_string = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display = nullptr;
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
};

namespace {

template <class Function> void load(void *library, const char *name, Function &function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (!function) throw Error(PDESC_ERROR_UNSUPPORTED, std::string("libEGL.so.1 has no ") + name + "; install a complete EGL.");
}

bool has_extension(const char *list, const char *name) {
  const std::string padded = std::string(" ") + (list ? list : "") + " ";
  return padded.find(std::string(" ") + name + " ") != std::string::npos;
}

struct Candidate {
  EGLenum platform;
  void *native;
};

} // namespace

// The entry points are looked up by name, so that nothing links libEGL and the library loads where there is none.
static void open_library(auto &egl) {
  egl.library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!egl.library)
    throw Error(
        PDESC_ERROR_UNSUPPORTED,
        "No EGL on this machine (libEGL.so.1 was not found); install it (Debian: libegl1 and libgl1-mesa-dri), or use the "
        "reference backend.");
  load(egl.library, "eglGetProcAddress", egl.get_proc_address);
  load(egl.library, "eglQueryString", egl.query_string);
  load(egl.library, "eglInitialize", egl.initialize);
  load(egl.library, "eglBindAPI", egl.bind_api);
  load(egl.library, "eglCreateContext", egl.create_context);
  load(egl.library, "eglDestroyContext", egl.destroy_context);
  load(egl.library, "eglMakeCurrent", egl.make_current);
  load(egl.library, "eglReleaseThread", egl.release_thread);
  auto optional = [&](const char *name, auto &function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(egl.get_proc_address(name));
  };
  optional("eglQueryDevicesEXT", egl.query_devices);
  optional("eglQueryDeviceStringEXT", egl.query_device_string);
  optional("eglGetPlatformDisplayEXT", egl.get_platform_display);
  if (!egl.get_platform_display)
    throw Error(PDESC_ERROR_UNSUPPORTED,
                "This EGL cannot run without a window (no EGL_EXT_platform_base); use the reference backend.");
}

// Devices of the kind asked for; Mesa's surfaceless platform, which may be of either kind, comes last.
static std::vector<Candidate> list_candidates(const auto &egl, bool software, int device_index) {
  std::vector<Candidate> candidates;
  const char *client = egl.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (egl.query_devices && egl.query_device_string && has_extension(client, "EGL_EXT_platform_device")) {
    EGLint count = 0;
    egl.query_devices(0, nullptr, &count);
    std::vector<EGLDeviceEXT> devices(static_cast<size_t>(count > 0 ? count : 0));
    if (count > 0) egl.query_devices(count, devices.data(), &count);
    for (EGLDeviceEXT device : devices) {
      const bool is_software = has_extension(egl.query_device_string(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
      if (is_software == software) candidates.push_back({EGL_PLATFORM_DEVICE_EXT, device});
    }
  }
  if (has_extension(client, "EGL_MESA_platform_surfaceless")) candidates.push_back({EGL_PLATFORM_SURFACELESS_MESA, nullptr});
  if (device_index < 0) return candidates;
  if (device_index >= static_cast<int>(candidates.size()))
    throw Error(PDESC_ERROR_UNSUPPORTED, "Device " + std::to_string(device_index) + " was asked for, but there are only " +
                                             std::to_string(candidates.size()) + "; choose a lower index or -1.");
  return {candidates[static_cast<size_t>(device_index)]};
}

// Makes a context on this display current; false leaves nothing behind. eglTerminate is never called: displays belong to the
// whole process, and the host's may be the same one.
static bool make_context(auto &egl, const Candidate &candidate) {
  egl.display = egl.get_platform_display(candidate.platform, candidate.native, nullptr);
  EGLint major = 0, minor = 0;
  if (egl.display == EGL_NO_DISPLAY || !egl.initialize(egl.display, &major, &minor)) return false;
  const char *extensions = egl.query_string(egl.display, EGL_EXTENSIONS);
  if (!has_extension(extensions, "EGL_KHR_surfaceless_context") || !has_extension(extensions, "EGL_KHR_no_config_context"))
    return false;
  if (!egl.bind_api(EGL_OPENGL_API)) return false;
  const EGLint attributes[] = {
      EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  egl.context = egl.create_context(egl.display, nullptr, EGL_NO_CONTEXT, attributes);
  if (egl.context == EGL_NO_CONTEXT) return false;
  if (egl.make_current(egl.display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl.context)) return true;
  egl.destroy_context(egl.display, egl.context);
  egl.context = EGL_NO_CONTEXT;
  return false;
}

static bool is_software_renderer(const std::string &name) {
  for (const char *known : {"llvmpipe", "softpipe", "swrast", "SWR", "SwiftShader"})
    if (name.find(known) != std::string::npos) return true;
  return false;
}

EglContext::EglContext(bool software, int device_index) : egl_(std::make_unique<Egl>()) {
  Egl &egl = *egl_;
  open_library(egl);
  for (const Candidate &candidate : list_candidates(egl, software, device_index)) {
    if (!make_context(egl, candidate)) continue;
#define PARADESC_LOAD(type, name) gl_.name = reinterpret_cast<type>(egl.get_proc_address("gl" #name));
    PARADESC_GL_FUNCTIONS(PARADESC_LOAD)
#undef PARADESC_LOAD
    device_ = reinterpret_cast<const char *>(gl_.GetString(GL_RENDERER));
    if (is_software_renderer(device_) == software) return;
    egl.make_current(egl.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl.destroy_context(egl.display, egl.context);
    egl.context = EGL_NO_CONTEXT;
  }
  throw Error(
      PDESC_ERROR_UNSUPPORTED,
      software ? "No software OpenGL 4.5 device was found by EGL; install Mesa (Debian: libgl1-mesa-dri), or use the reference "
                 "backend."
               : "No hardware OpenGL 4.5 device was found by EGL; install its driver, or use the software or reference backend.");
}

EglContext::~EglContext() {
  if (egl_->context == EGL_NO_CONTEXT) return;
  egl_->make_current(egl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  egl_->destroy_context(egl_->display, egl_->context);
  egl_->release_thread();
}

void check_gl(const Gl &gl, const char *stage) {
  const GLenum code = gl.GetError();
  if (code == GL_NO_ERROR) return;
  if (code == GL_OUT_OF_MEMORY)
    throw Error(PDESC_ERROR_OUT_OF_MEMORY,
                std::string("The graphics device ran out of memory in stage ") + stage + "; use smaller buffers.");
  throw Error(PDESC_ERROR_UNKNOWN, std::string("OpenGL error ") + std::to_string(code) + " in stage " + stage +
                                       "; please report it with the device's name, and use the reference backend meanwhile.");
}

} // namespace paradesc
