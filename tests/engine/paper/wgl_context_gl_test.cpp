// A WGL that lacks something, or has a driver that is none: one sentence. Robust contexts are asked for where they
// are offered, and the hidden window answers.
#define NOMINMAX
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#undef MemoryBarrier // which OpenGL has as well

#include <vector>

#include <gtest/gtest.h>

#include "engine/paper/faults.h"
#include "engine/paper/gl_thread.h"
#include "support/run.h"

namespace paradesc::test {
namespace {

HGLRC WINAPI no_context(HDC) { return nullptr; }
BOOL WINAPI not_current(HDC, HGLRC) { return FALSE; }
int WINAPI no_format(HDC, const PIXELFORMATDESCRIPTOR *) { return 0; }
HWND WINAPI no_window(DWORD, LPCWSTR, LPCWSTR, DWORD, int, int, int, int, HWND, HMENU, HINSTANCE, LPVOID) { return nullptr; }
const GLubyte *APIENTRY no_driver(GLenum) { return reinterpret_cast<const GLubyte *>("GDI Generic"); }
const GLubyte *APIENTRY over_direct3d(GLenum) { return reinterpret_cast<const GLubyte *>("D3D12 (Some adapter)"); }

using CreateContextAttribs = HGLRC(WINAPI *)(HDC, HGLRC, const int *);
CreateContextAttribs real_create = nullptr;
std::vector<std::vector<int>> requested; // attributes of each context
std::vector<HGLRC> shared;
bool robust_fails = false;
const char *WINAPI with_robustness(HDC) { return "WGL_ARB_create_context WGL_ARB_create_context_robustness"; }
const char *WINAPI without_robustness(HDC) { return "WGL_ARB_create_context WGL_ARB_create_context_robustness_not"; }
HGLRC WINAPI remember(HDC dc, HGLRC other, const int *attributes) {
  std::vector<int> all;
  for (; *attributes != 0; attributes += 2) all.insert(all.end(), attributes, attributes + 2);
  requested.push_back(all);
  shared.push_back(other);
  return robust_fails && all.size() > 6 ? nullptr : real_create(dc, other, attributes - all.size());
}

class WglContext : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    if (!open_context(device_backend(), why_not)) GTEST_SKIP() << why_not;
    requested.clear();
    shared.clear();
    robust_fails = false;
  }
  static DriverSubstitute remembering(const char *(WINAPI *extensions)(HDC)) {
    return [put = DriverSubstitute(
                FailingDriver().put("wglGetExtensionsStringARB", extensions).put("wglCreateContextAttribsARB", remember))](
               const char *name, void *found) {
      if (std::string(name) == "wglCreateContextAttribsARB") real_create = reinterpret_cast<CreateContextAttribs>(found);
      return put(name, found);
    };
  }
  static bool is_robust(const std::vector<int> &attributes) {
    bool bounded = false, tells = false;
    for (size_t i = 0; i + 1 < attributes.size(); i += 2) {
      bounded = bounded || (attributes[i] == 0x2094 && (attributes[i + 1] & 4)); // WGL_CONTEXT_FLAGS_ARB, robust access
      tells = tells || (attributes[i] == 0x8256 && attributes[i + 1] == 0x8252); // lose context on reset
    }
    return bounded && tells;
  }
  // Returns the hidden window of this process; another process may compute beside it.
  static HWND hidden_window() {
    HWND window = nullptr;
    while ((window = FindWindowExW(nullptr, window, L"paradesc", nullptr)) != nullptr) {
      DWORD process = 0;
      GetWindowThreadProcessId(window, &process);
      if (process == GetCurrentProcessId()) break;
    }
    return window;
  }
};

TEST_F(WglContext, is_refused_where_a_function_is_missing) {
  for (const char *name : {"wglCreateContext", "wglGetProcAddress", "ChoosePixelFormat", "CreateWindowExW", "PostThreadMessageW"})
    expect_refused(FailingDriver().without(name), name);
  for (const char *name : {"gdi32.dll", "user32.dll"}) expect_refused(FailingDriver().without(name), name);
}

TEST_F(WglContext, is_refused_where_nothing_can_be_made_current) {
  expect_refused(FailingDriver().put("CreateWindowExW", no_window), no_device());
  expect_refused(FailingDriver().put("ChoosePixelFormat", no_format), no_device());
  expect_refused(FailingDriver().put("wglCreateContext", no_context), no_device());
  expect_refused(FailingDriver().put("wglMakeCurrent", not_current), no_device());
}

TEST_F(WglContext, of_no_driver_or_over_direct3d_counts_as_none) {
  expect_refused(FailingDriver().put("glGetString", no_driver), "GDI Generic was left out: it stands for a missing driver");
  expect_refused(FailingDriver().put("glGetString", over_direct3d), "D3D12 (Some adapter) was left out");
  try {
    const GlContext context(false, -1, FailingDriver().put("glGetString", no_driver));
    ADD_FAILURE() << "it was taken for a card";
  } catch (const Error &error) {
    EXPECT_NE(std::string(error.what()).find("Remote Desktop"), std::string::npos) << error.what();
    expect_one_sentence(error.what());
  }
}

TEST_F(WglContext, has_one_device_of_number_0) {
  EXPECT_NE(GlContext(!on_card(), 0).device(), "");
  try {
    const GlContext context(!on_card(), 1);
    ADD_FAILURE() << "there is a second device";
  } catch (const Error &error) {
    EXPECT_NE(std::string(error.what()).find("there is only 1"), std::string::npos) << error.what();
    expect_one_sentence(error.what());
  }
}

TEST_F(WglContext, is_robust_where_that_is_offered) {
  { const GlContext context(!on_card(), -1, remembering(with_robustness)); }
  ASSERT_EQ(requested.size(), 1u);
  EXPECT_TRUE(is_robust(requested[0]));
  { const GlContext context(!on_card(), -1, remembering(without_robustness)); }
  ASSERT_EQ(requested.size(), 2u);
  EXPECT_FALSE(is_robust(requested[1]));
  robust_fails = true;
  { const GlContext context(!on_card(), -1, remembering(with_robustness)); }
  ASSERT_EQ(requested.size(), 4u) << "what is offered and fails is not insisted on";
  EXPECT_FALSE(is_robust(requested[3]));
  EXPECT_EQ(shared, std::vector<HGLRC>(4, nullptr)) << "nothing is shared between contexts";
}

TEST_F(WglContext, has_a_window_that_answers_while_the_device_waits_and_goes_with_it) {
  ASSERT_EQ(hidden_window(), nullptr);
  {
    const GlThread thread(!on_card(), -1);
    const HWND window = hidden_window();
    ASSERT_NE(window, nullptr);
    EXPECT_FALSE(IsWindowVisible(window));
    DWORD_PTR answer = 0;
    EXPECT_NE(SendMessageTimeoutW(window, WM_NULL, 0, 0, SMTO_ABORTIFHUNG, 5000, &answer), 0);
  }
  EXPECT_EQ(hidden_window(), nullptr);
}

} // namespace
} // namespace paradesc::test
