// libEGL, opened at run time → a current OpenGL 4.5 core context without a window.
#include "engine/paper/system_context.h"

#define EGL_NO_X11
#define MESA_EGL_NO_X11_HEADERS
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <vector>

#include "support/error.h"

namespace paradesc {

namespace {

struct Candidate {
  EGLenum platform;
  void *native;
};

} // namespace

struct SystemContext::System {
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
  std::vector<Candidate> candidates;
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  DriverSubstitute substitute;

  // The driver's function of that name, or a test's substitute for it.
  void *chosen(const char *name, void *found) const { return substitute ? substitute(name, found) : found; }
  template <class Function> bool load(const char *name, Function &function) const {
    void *found =
        get_proc_address && !dlsym(library, name) ? reinterpret_cast<void *>(get_proc_address(name)) : dlsym(library, name);
    function = reinterpret_cast<Function>(chosen(name, found));
    return function != nullptr;
  }
};

// Looks up entry points by name, so that nothing links libEGL and the library also loads on systems without it.
static void open_library(auto &egl) {
  egl.library = egl.chosen("libEGL.so.1", dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL));
  if (!egl.library)
    throw Error(
        PDESC_ERROR_UNSUPPORTED,
        "No EGL on this machine (libEGL.so.1 was not found); install it (Debian: libegl1 and libgl1-mesa-dri), or use the "
        "cpu backend.");
  auto need = [&](const char *name, auto &function) {
    if (!egl.load(name, function))
      throw Error(PDESC_ERROR_UNSUPPORTED,
                  std::string("libEGL.so.1 has no ") + name + "; install a complete EGL, or use the cpu backend.");
  };
  need("eglGetProcAddress", egl.get_proc_address);
  need("eglQueryString", egl.query_string);
  need("eglInitialize", egl.initialize);
  need("eglBindAPI", egl.bind_api);
  need("eglCreateContext", egl.create_context);
  need("eglDestroyContext", egl.destroy_context);
  need("eglMakeCurrent", egl.make_current);
  need("eglReleaseThread", egl.release_thread);
  egl.load("eglQueryDevicesEXT", egl.query_devices);
  egl.load("eglQueryDeviceStringEXT", egl.query_device_string);
  if (!egl.load("eglGetPlatformDisplayEXT", egl.get_platform_display))
    throw Error(PDESC_ERROR_UNSUPPORTED, "This EGL cannot run without a window (no EGL_EXT_platform_base); use the cpu backend.");
}

SystemContext::SystemContext(const DriverSubstitute &substitute) : system_(std::make_unique<System>()) {
  system_->substitute = substitute;
  open_library(*system_);
}

SystemContext::~SystemContext() {
  if (system_->context == EGL_NO_CONTEXT) return;
  drop();
  system_->release_thread();
}

// Lists Mesa's surfaceless platform last, because it may be of either kind.
int SystemContext::list_devices(bool software) {
  System &egl = *system_;
  egl.candidates.clear();
  const char *client = egl.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (egl.query_devices && egl.query_device_string && has_extension(client, "EGL_EXT_platform_device")) {
    EGLint count = 0;
    egl.query_devices(0, nullptr, &count);
    std::vector<EGLDeviceEXT> devices(static_cast<size_t>(count > 0 ? count : 0));
    if (count > 0) egl.query_devices(count, devices.data(), &count);
    for (EGLDeviceEXT device : devices) {
      const bool is_software = has_extension(egl.query_device_string(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
      if (is_software == software) egl.candidates.push_back({EGL_PLATFORM_DEVICE_EXT, device});
    }
  }
  if (has_extension(client, "EGL_MESA_platform_surfaceless")) egl.candidates.push_back({EGL_PLATFORM_SURFACELESS_MESA, nullptr});
  return static_cast<int>(egl.candidates.size());
}

// Never calls eglTerminate: displays belong to the whole process, and the host may use the same one.
bool SystemContext::make_current(int device) {
  System &egl = *system_;
  const Candidate &candidate = egl.candidates[static_cast<size_t>(device)];
  egl.display = egl.get_platform_display(candidate.platform, candidate.native, nullptr);
  EGLint major = 0, minor = 0;
  if (egl.display == EGL_NO_DISPLAY || !egl.initialize(egl.display, &major, &minor)) return false;
  const char *extensions = egl.query_string(egl.display, EGL_EXTENSIONS);
  if (!has_extension(extensions, "EGL_KHR_surfaceless_context") || !has_extension(extensions, "EGL_KHR_no_config_context"))
    return false;
  if (!egl.bind_api(EGL_OPENGL_API)) return false;
  const std::vector<EGLint> version = {
      EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  std::vector<EGLint> robust(version.begin(), version.end() - 1);
  robust.insert(robust.end(), {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET,
                               EGL_CONTEXT_OPENGL_ROBUST_ACCESS, EGL_TRUE, EGL_NONE});
  if (10 * major + minor < 15) robust = version;
  // The last attempt is for an error sentence that says what an older device offers.
  for (const std::vector<EGLint> &attributes : {robust, version, std::vector<EGLint>{EGL_NONE}})
    if (egl.context == EGL_NO_CONTEXT) egl.context = egl.create_context(egl.display, nullptr, EGL_NO_CONTEXT, attributes.data());
  if (egl.context == EGL_NO_CONTEXT) return false;
  if (egl.make_current(egl.display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl.context)) return true;
  egl.destroy_context(egl.display, egl.context);
  egl.context = EGL_NO_CONTEXT;
  return false;
}

void SystemContext::drop() {
  System &egl = *system_;
  egl.make_current(egl.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  egl.destroy_context(egl.display, egl.context);
  egl.context = EGL_NO_CONTEXT;
}

void *SystemContext::function(const char *name) const {
  return system_->chosen(name, reinterpret_cast<void *>(system_->get_proc_address(name)));
}

std::string SystemContext::flaw_of(const std::string &) { return ""; }
const char *SystemContext::library() { return "EGL"; }
const char *SystemContext::software_advice() { return "install Mesa (Debian: libgl1-mesa-dri)"; }

} // namespace paradesc
