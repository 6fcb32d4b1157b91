// opengl32.dll, opened at run time → a current OpenGL 4.5 core context on an invisible window.
#include "engine/paper/system_context.h"

#define NOMINMAX
#define WIN32_LEAN_AND_MEAN
#include <windows.h>

#include <array>
#include <future>
#include <thread>
#include <type_traits>
#include <utility>

#include "support/error.h"

namespace paradesc {

namespace {

// Constants of WGL_ARB_create_context, its profiles and its robustness extension.
using CreateContextAttribs = HGLRC(WINAPI *)(HDC, HGLRC, const int *);
using GetExtensionsString = const char *(WINAPI *)(HDC);
constexpr int MAJOR_VERSION = 0x2091, MINOR_VERSION = 0x2092, FLAGS = 0x2094, PROFILE_MASK = 0x9126, CORE_PROFILE_BIT = 1,
              ROBUST_ACCESS_BIT = 4, RESET_NOTIFICATION_STRATEGY = 0x8256, LOSE_CONTEXT_ON_RESET = 0x8252;

struct WindowFunctions {
  decltype(&::RegisterClassExW) register_class = nullptr;
  decltype(&::CreateWindowExW) create_window = nullptr;
  decltype(&::DestroyWindow) destroy_window = nullptr;
  decltype(&::DefWindowProcW) default_procedure = nullptr;
  decltype(&::GetDC) get_dc = nullptr;
  decltype(&::ReleaseDC) release_dc = nullptr;
  decltype(&::GetMessageW) get_message = nullptr;
  decltype(&::DispatchMessageW) dispatch_message = nullptr;
  decltype(&::PostThreadMessageW) post_thread_message = nullptr;
};

// A window that is never shown. It has a thread of its own, which answers the messages that the system sends to every window: a
// window that does not answer blocks the sender, and OpenGL's thread may compute for seconds, or wait for work for hours.
class HiddenWindow {
public:
  explicit HiddenWindow(const WindowFunctions &windows) : windows_(windows) {
    std::promise<void> made;
    std::future<void> waiting = made.get_future();
    thread_ = std::thread([this, made = std::move(made)]() mutable { live(std::move(made)); });
    waiting.wait();
  }
  ~HiddenWindow() {
    windows_.post_thread_message(thread_id_, WM_QUIT, 0, 0);
    thread_.join();
  }
  HiddenWindow(const HiddenWindow &) = delete;
  HiddenWindow &operator=(const HiddenWindow &) = delete;

  HDC dc() const { return dc_; } // or nullptr

private:
  // The window class is this library's own, with the system's procedure, so it may outlive the library. A second registration is
  // refused, which leaves the first in effect.
  HWND make() const {
    HMODULE self = nullptr;
    GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                       reinterpret_cast<LPCWSTR>(&SystemContext::library), &self);
    WNDCLASSEXW kind{};
    kind.cbSize = sizeof kind;
    kind.style = CS_OWNDC;
    kind.lpfnWndProc = windows_.default_procedure;
    kind.hInstance = self;
    kind.lpszClassName = L"paradesc";
    windows_.register_class(&kind);
    return windows_.create_window(0, kind.lpszClassName, L"", WS_POPUP, 0, 0, 1, 1, nullptr, nullptr, self, nullptr);
  }

  void live(std::promise<void> made) {
    thread_id_ = GetCurrentThreadId();
    const HWND window = make();
    dc_ = window ? windows_.get_dc(window) : nullptr;
    made.set_value();
    if (!window) return;
    for (MSG message; windows_.get_message(&message, nullptr, 0, 0) > 0;)
      if (message.message != WM_CLOSE) windows_.dispatch_message(&message); // a request to close all windows is for the host's
    if (dc_) windows_.release_dc(window, dc_);
    windows_.destroy_window(window);
  }

  const WindowFunctions &windows_;
  DWORD thread_id_ = 0;
  HDC dc_ = nullptr;
  std::thread thread_;
};

} // namespace

struct SystemContext::System {
  HMODULE opengl = nullptr;
  decltype(&::wglCreateContext) create_context = nullptr;
  decltype(&::wglDeleteContext) delete_context = nullptr;
  decltype(&::wglGetProcAddress) get_proc_address = nullptr;
  decltype(&::wglMakeCurrent) make_current = nullptr;
  decltype(&::ChoosePixelFormat) choose_format = nullptr;
  decltype(&::SetPixelFormat) set_format = nullptr;
  WindowFunctions windows;
  std::unique_ptr<HiddenWindow> window;
  HGLRC context = nullptr;
  DriverSubstitute substitute;

  // The driver's function of that name, or a test's substitute for it.
  void *chosen(const char *name, void *found) const { return substitute ? substitute(name, found) : found; }

  // Extensions come from the driver, functions of OpenGL 1.1 only from the library. Some drivers return small numbers instead of
  // nullptr.
  void *function(const char *name) const {
    const auto found = reinterpret_cast<INT_PTR>(get_proc_address(name));
    const bool is_number = found >= -1 && found <= 3;
    return chosen(name, is_number ? reinterpret_cast<void *>(GetProcAddress(opengl, name)) : reinterpret_cast<void *>(found));
  }
};

// Searches only the program's and the system's folders.
static HMODULE open_library(const auto &wgl, const char *name) {
  const auto found = reinterpret_cast<HMODULE>(
      wgl.chosen(name, reinterpret_cast<void *>(LoadLibraryExA(name, nullptr, LOAD_LIBRARY_SEARCH_DEFAULT_DIRS))));
  if (!found)
    throw Error(PDESC_ERROR_UNSUPPORTED,
                std::string("No OpenGL on this machine (") + name + " was not found); use the cpu backend.");
  return found;
}

static void open_libraries(auto &wgl) {
  wgl.opengl = open_library(wgl, "opengl32.dll");
  const HMODULE gdi = open_library(wgl, "gdi32.dll"), user = open_library(wgl, "user32.dll");
  auto need = [&](HMODULE library, const char *name, auto &function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(
        wgl.chosen(name, reinterpret_cast<void *>(GetProcAddress(library, name))));
    if (!function)
      throw Error(PDESC_ERROR_UNSUPPORTED,
                  std::string("Windows has no ") + name + " on this machine; use the cpu backend, which does without OpenGL.");
  };
  need(wgl.opengl, "wglCreateContext", wgl.create_context);
  need(wgl.opengl, "wglDeleteContext", wgl.delete_context);
  need(wgl.opengl, "wglGetProcAddress", wgl.get_proc_address);
  need(wgl.opengl, "wglMakeCurrent", wgl.make_current);
  need(gdi, "ChoosePixelFormat", wgl.choose_format);
  need(gdi, "SetPixelFormat", wgl.set_format);
  need(user, "RegisterClassExW", wgl.windows.register_class);
  need(user, "CreateWindowExW", wgl.windows.create_window);
  need(user, "DestroyWindow", wgl.windows.destroy_window);
  need(user, "DefWindowProcW", wgl.windows.default_procedure);
  need(user, "GetDC", wgl.windows.get_dc);
  need(user, "ReleaseDC", wgl.windows.release_dc);
  need(user, "GetMessageW", wgl.windows.get_message);
  need(user, "DispatchMessageW", wgl.windows.dispatch_message);
  need(user, "PostThreadMessageW", wgl.windows.post_thread_message);
}

// Sets a pixel format that all drivers have; nothing is ever drawn into the window itself.
static bool set_format(const auto &wgl) {
  PIXELFORMATDESCRIPTOR format{};
  format.nSize = sizeof format;
  format.nVersion = 1;
  format.dwFlags = PFD_DRAW_TO_WINDOW | PFD_SUPPORT_OPENGL | PFD_DOUBLEBUFFER;
  format.iPixelType = PFD_TYPE_RGBA;
  format.cColorBits = 32;
  format.cDepthBits = 24;
  format.cStencilBits = 8;
  const int number = wgl.choose_format(wgl.window->dc(), &format);
  return number != 0 && wgl.set_format(wgl.window->dc(), number, &format);
}

// Makes an OpenGL 4.5 core context in place of the current one, which is used to query WGL's extensions; nullptr if that fails.
// Robustness is requested only if it is offered, because a driver that does not know the attributes may ignore them.
static HGLRC make_core_context(const auto &wgl) {
  const auto extensions = reinterpret_cast<GetExtensionsString>(wgl.function("wglGetExtensionsStringARB"));
  const auto create = reinterpret_cast<CreateContextAttribs>(wgl.function("wglCreateContextAttribsARB"));
  if (!extensions || !create) return nullptr;
  const HDC dc = wgl.window->dc();
  const std::array version = {MAJOR_VERSION, 4, MINOR_VERSION, 5, PROFILE_MASK, CORE_PROFILE_BIT, 0};
  const std::array robust = {MAJOR_VERSION,
                             4,
                             MINOR_VERSION,
                             5,
                             PROFILE_MASK,
                             CORE_PROFILE_BIT,
                             FLAGS,
                             ROBUST_ACCESS_BIT,
                             RESET_NOTIFICATION_STRATEGY,
                             LOSE_CONTEXT_ON_RESET,
                             0};
  HGLRC made = nullptr;
  if (has_extension(extensions(dc), "WGL_ARB_create_context_robustness")) made = create(dc, nullptr, robust.data());
  return made ? made : create(dc, nullptr, version.data());
}

SystemContext::SystemContext(const DriverSubstitute &substitute) : system_(std::make_unique<System>()) {
  system_->substitute = substitute;
  open_libraries(*system_);
}

SystemContext::~SystemContext() { drop(); }

// WGL cannot list devices: Windows, or the driver's own settings, choose the card of a program.
int SystemContext::list_devices(bool) { return 1; }

// Contexts with attributes are made by a function that only a context without attributes can provide.
bool SystemContext::make_current(int) {
  System &wgl = *system_;
  wgl.window = std::make_unique<HiddenWindow>(wgl.windows);
  const HDC dc = wgl.window->dc();
  if (dc && set_format(wgl)) wgl.context = wgl.create_context(dc);
  if (!wgl.context || !wgl.make_current(dc, wgl.context)) {
    drop();
    return false;
  }
  const HGLRC core = make_core_context(wgl);
  if (!core) return true; // for the sentence that says what an older device offers
  const bool is_current = wgl.make_current(dc, core);
  wgl.delete_context(std::exchange(wgl.context, core));
  if (!is_current) drop();
  return is_current;
}

void SystemContext::drop() {
  System &wgl = *system_;
  if (wgl.context) {
    wgl.make_current(nullptr, nullptr);
    wgl.delete_context(wgl.context);
  }
  wgl.context = nullptr;
  wgl.window.reset();
}

void *SystemContext::function(const char *name) const { return system_->function(name); }

std::string SystemContext::flaw_of(const std::string &device) {
  if (device.starts_with("GDI Generic")) return "it stands for a missing driver, as over Remote Desktop";
  if (device.starts_with("D3D12"))
    return "Mesa draws by Direct3D 12 there, which ended Blender itself on machines with Windows on ARM";
  return "";
}

const char *SystemContext::library() { return "WGL"; }
const char *SystemContext::software_advice() { return "lay the opengl32.dll of Mesa's llvmpipe beside the program"; }

} // namespace paradesc
