// libEGL, opened at run time → a current OpenGL 4.5 core context without a window.
#include "engine/opengl/egl_context.h"

#define EGL_NO_X11
#define MESA_EGL_NO_X11_HEADERS
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <limits>
#include <type_traits>
#include <vector>

#include "support/error.h"
#include "support/math.h"

#include "shared.h"

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
  DriverSubstitute substitute;

  // The driver's function of that name, or the one that a test substitutes.
  void *chosen(const char *name, void *found) const { return substitute ? substitute(name, found) : found; }
  template <class Function> bool load(const char *name, Function &function) const {
    void *found =
        get_proc_address && !dlsym(library, name) ? reinterpret_cast<void *>(get_proc_address(name)) : dlsym(library, name);
    function = reinterpret_cast<Function>(chosen(name, found));
    return function != nullptr;
  }
};

namespace {

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
  egl.library = egl.chosen("libEGL.so.1", dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL));
  if (!egl.library)
    throw Error(
        PDESC_ERROR_UNSUPPORTED,
        "No EGL on this machine (libEGL.so.1 was not found); install it (Debian: libegl1 and libgl1-mesa-dri), or use the "
        "reference backend.");
  auto need = [&](const char *name, auto &function) {
    if (!egl.load(name, function))
      throw Error(PDESC_ERROR_UNSUPPORTED,
                  std::string("libEGL.so.1 has no ") + name + "; install a complete EGL, or use the reference backend.");
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
  return {candidates[device_index]};
}

// Makes a context on this display current; false leaves nothing behind. eglTerminate is never called: displays belong to the
// whole process, and the host's may be the same one. A context that bounds what shaders reach and says when the device was
// reset is taken where it is offered.
static bool make_context(auto &egl, const Candidate &candidate) {
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
  // The last is for the sentence that says what an older device offers.
  for (const std::vector<EGLint> &attributes : {robust, version, std::vector<EGLint>{EGL_NONE}})
    if (egl.context == EGL_NO_CONTEXT) egl.context = egl.create_context(egl.display, nullptr, EGL_NO_CONTEXT, attributes.data());
  if (egl.context == EGL_NO_CONTEXT) return false;
  if (egl.make_current(egl.display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl.context)) return true;
  egl.destroy_context(egl.display, egl.context);
  egl.context = EGL_NO_CONTEXT;
  return false;
}

static void drop_context(auto &egl) {
  egl.make_current(egl.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  egl.destroy_context(egl.display, egl.context);
  egl.context = EGL_NO_CONTEXT;
}

static bool is_software_renderer(const std::string &name) {
  for (const char *known : {"llvmpipe", "softpipe", "swrast", "SWR", "SwiftShader"})
    if (name.find(known) != std::string::npos) return true;
  return false;
}

// Drivers that say less than OpenGL 4.5 promises are not believed to be one; what they say beyond is believed until it fails.
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

std::string EglContext::look_at_context(bool software) {
  std::string missing;
  auto load = [&](const char *name, auto &function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(
        egl_->chosen(name, reinterpret_cast<void *>(egl_->get_proc_address(name))));
    if (!function && missing.empty()) missing = name;
  };
#define PARADESC_LOAD(type, name) load("gl" #name, gl_.name);
  PARADESC_GL_FUNCTIONS(PARADESC_LOAD)
#undef PARADESC_LOAD
  if (!gl_.GetString || !gl_.GetIntegerv) return "its driver has no glGetString";
  const auto *name = reinterpret_cast<const char *>(gl_.GetString(GL_RENDERER));
  device_ = name ? name : "a device without a name";
  if (is_software_renderer(device_) != software) return software ? "it is hardware" : "it is a software rasterizer";
  GLint major = 0, minor = 0;
  gl_.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl_.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (10 * major + minor < 45) return "it offers OpenGL " + std::to_string(major) + "." + std::to_string(minor);
  if (!missing.empty()) return "its driver has no " + missing;
  const std::string flaw = read_limits(gl_);
  gl_.limits.group_size = software ? 16 : 64;
  // llvmpipe says 2^27 bytes and takes more; a test has it reach the end of a longer one.
  if (software) gl_.limits.storage_bytes = std::numeric_limits<GLint64>::max();
  return flaw;
}

EglContext::EglContext(bool software, int device_index, const DriverSubstitute &substitute) : egl_(std::make_unique<Egl>()) {
  Egl &egl = *egl_;
  egl.substitute = substitute;
  open_library(egl);
  std::string refused; // the last one of the kind asked for
  for (const Candidate &candidate : list_candidates(egl, software, device_index)) {
    if (!make_context(egl, candidate)) continue;
    const std::string flaw = look_at_context(software);
    if (flaw.empty()) return;
    if (!flaw.starts_with("it is ")) refused = " (" + (device_.empty() ? "a device" : device_) + " was left out: " + flaw + ")";
    drop_context(egl);
  }
  throw Error(PDESC_ERROR_UNSUPPORTED, software ? "No software OpenGL 4.5 device was found by EGL" + refused +
                                                      "; install Mesa (Debian: libgl1-mesa-dri), or use the reference backend."
                                                : "No hardware OpenGL 4.5 device was found by EGL" + refused +
                                                      "; install its driver, or use the software or reference backend.");
}

EglContext::~EglContext() {
  if (egl_->context == EGL_NO_CONTEXT) return;
  drop_context(*egl_);
  egl_->release_thread();
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
                                       "; please report it with the device's name, and use the reference backend meanwhile.");
}

} // namespace paradesc
