// An EGL that lacks something: one sentence.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <gtest/gtest.h>

#include "engine/paper/faults.h"
#include "support/run.h"

namespace paradesc::test {
namespace {

EGLContext EGLAPIENTRY no_context(EGLDisplay, EGLConfig, EGLContext, const EGLint *) { return EGL_NO_CONTEXT; }
EGLBoolean EGLAPIENTRY no_display(EGLDisplay, EGLint *, EGLint *) { return EGL_FALSE; }
EGLBoolean EGLAPIENTRY not_current(EGLDisplay, EGLSurface, EGLSurface, EGLContext) { return EGL_FALSE; }
EGLBoolean EGLAPIENTRY no_devices(EGLint, EGLDeviceEXT *, EGLint *count) {
  *count = 0;
  return EGL_TRUE;
}
const char *EGLAPIENTRY no_extensions(EGLDisplay, EGLint) { return nullptr; }

class EglContext : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    if (!open_context(device_backend(), why_not)) GTEST_SKIP() << why_not;
  }
};

TEST_F(EglContext, is_refused_where_a_function_is_missing) {
  expect_refused(FailingDriver().without("eglCreateContext"), "has no eglCreateContext");
  expect_refused(FailingDriver().without("eglGetPlatformDisplayEXT"), "without a window");
}

TEST_F(EglContext, is_refused_where_nothing_can_be_made_current) {
  expect_refused(FailingDriver().put("eglQueryString", no_extensions), no_device());
  expect_refused(FailingDriver().put("eglInitialize", no_display), no_device());
  expect_refused(FailingDriver().put("eglCreateContext", no_context), no_device());
  expect_refused(FailingDriver().put("eglMakeCurrent", not_current), no_device());
}

TEST_F(EglContext, may_come_without_a_surface_where_no_device_is_listed) {
  try {
    const GlContext context(!on_card(), -1, FailingDriver().put("eglQueryDevicesEXT", no_devices));
    EXPECT_NE(context.device(), "");
  } catch (const Error &error) {
    EXPECT_NE(std::string(error.what()).find(no_device()), std::string::npos) << error.what();
    expect_one_sentence(error.what());
  }
}

} // namespace
} // namespace paradesc::test
