// A driver that fails, at first or in the middle: one sentence, and a context that stays usable.
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "compute/compute.h"
#include "context.h"
#include "descriptor/registry.h"
#include "engine/paper/buffer.h"
#include "engine/paper/faults.h"
#include "engine/paper/gl_thread.h"
#include "shared.h"
#include "support/layout.h"
#include "support/run.h"
#include "support/sentence.h"

namespace paradesc {
namespace {

using test::FailingDriver;

// ---- What a driver may do. Functions of C have no state of their own, so it stands here; every test begins with set_up().

struct Script {
  std::atomic<int> opened = 0;     // times that the system's library was opened
  std::atomic<int> dispatches = 0; // since set_up
  std::atomic<int> lose_at = 0;    // the dispatch with which the device is lost; 0: never
  std::atomic<int> fail_at = 0;    // the dispatch after which the device is out of memory
  std::atomic<bool> lost = false;
  std::atomic<bool> failing = false;
};
Script script;
PFNGLDISPATCHCOMPUTEPROC real_dispatch = nullptr;
PFNGLGETERRORPROC real_error = nullptr;
PFNGLGETINTEGERVPROC real_integer = nullptr;
PFNGLGETSHADERIVPROC real_shader = nullptr;
PFNGLGETPROGRAMIVPROC real_program = nullptr;

void APIENTRY dispatch(GLuint x, GLuint y, GLuint z) {
  const int number = ++script.dispatches;
  if (number == script.lose_at) script.lost = true;
  if (number == script.fail_at) script.failing = true;
  if (!script.lost) real_dispatch(x, y, z);
}
void APIENTRY dispatch_nothing(GLuint, GLuint, GLuint) {}
GLenum APIENTRY reset_status() { return script.lost ? GL_GUILTY_CONTEXT_RESET : GL_NO_ERROR; }
GLenum APIENTRY error_status() { return script.failing.exchange(false) ? GL_OUT_OF_MEMORY : real_error(); }
void APIENTRY old_version(GLenum name, GLint *value) {
  real_integer(name, value);
  if (name == GL_MAJOR_VERSION) *value = 3;
}
void APIENTRY no_textures(GLenum name, GLint *value) {
  real_integer(name, value);
  if (name == GL_MAX_TEXTURE_SIZE) *value = 0;
}
void APIENTRY one_group(GLenum, GLuint, GLint *value) { *value = 1; }
void APIENTRY no_storage(GLenum, GLint64 *value) { *value = -1; }
void APIENTRY not_compiled(GLuint shader, GLenum name, GLint *value) {
  real_shader(shader, name, value);
  if (name == GL_COMPILE_STATUS) *value = 0;
}
void APIENTRY not_linked(GLuint program, GLenum name, GLint *value) {
  real_program(program, name, value);
  if (name == GL_LINK_STATUS) *value = 0;
}
void APIENTRY long_log(GLuint, GLsizei room, GLsizei *length, GLchar *log) {
  const std::string text = "0:1(2): error: no\n0:3(4): error: never\n" + std::string(5000, 'x');
  const auto used = static_cast<GLsizei>(text.copy(log, static_cast<size_t>(room - 1)));
  log[used] = 0;
  if (length) *length = used;
}
GLenum APIENTRY incomplete(GLuint, GLenum) { return GL_FRAMEBUFFER_UNSUPPORTED; }

// The driver's own functions, which the scripted ones go on to.
DriverSubstitute scripted(const FailingDriver &failing) {
  return [put = DriverSubstitute(failing)](const char *name, void *found) {
    const std::string requested = name;
    auto keep = [&](const char *wanted, auto &function) {
      if (requested == wanted) function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
    };
    if (requested == test::driver_library) ++script.opened;
    keep("glDispatchCompute", real_dispatch);
    keep("glGetError", real_error);
    keep("glGetIntegerv", real_integer);
    keep("glGetShaderiv", real_shader);
    keep("glGetProgramiv", real_program);
    return put(name, found);
  };
}

// ---- What is done with it

class DriverFailures : public ::testing::Test {
protected:
  void SetUp() override {
    script.opened = script.dispatches = script.lose_at = script.fail_at = 0;
    script.lost = script.failing = false;
    ball = test::sphere(1, {.vertices = 400});
    test::lay_out(ball, {.charts = 6});
    pdesc_options_init(&options);
    options.radius = 0.1;
    options.buffer_size = 128;
    options.samples = 16;
  }

  // False, and the test is skipped, where there is no device to fail.
  static bool has(int32_t backend) {
    std::string why_not;
    return test::open_context(backend, why_not) != nullptr;
  }
  static bool has_device() { return has(test::device_backend()); }

  static std::shared_ptr<Context> open(int32_t backend, const FailingDriver &failing) {
    pdesc_context_options requested;
    pdesc_context_options_init(&requested);
    requested.backend = backend;
    return make_context(requested, scripted(failing));
  }

  Field compute_on(Mesh &mesh) const { return compute_on(mesh, options); }
  static Field compute_on(Mesh &mesh, const pdesc_options &chosen) {
    const std::vector<int> requested = {find_descriptor("mean_curvature")};
    return compute(mesh, chosen, requested, [](const char *, double) { return true; });
  }
  std::unique_ptr<Mesh> mesh_on(const std::shared_ptr<Context> &context) const { return make_mesh(context, input_of(ball)); }

  // So is what needs it under AUTO, which computes all else by the processor.
  void expect_refused_at_once(const FailingDriver &failing, const char *word) const {
    test::expect_refused(scripted(failing), word);
    const auto mesh = mesh_on(open(PDESC_BACKEND_AUTO, failing));
    EXPECT_EQ(compute_on(*mesh).report.backend, PDESC_BACKEND_CPU);
    pdesc_options half = options;
    half.precision = PDESC_PRECISION_HALF;
    try {
      compute_on(*mesh, half);
      ADD_FAILURE() << "half floats were computed: " << word;
    } catch (const Error &error) {
      EXPECT_EQ(error.status(), PDESC_ERROR_UNSUPPORTED);
      test::expect_one_sentence(error.what(), test::on_card() ? "no software device" : word); // beside a card there may be none
      test::expect_one_sentence(error.what(), "half floats");
    }
    EXPECT_EQ(compute_on(*mesh).report.backend, PDESC_BACKEND_CPU) << "the mesh stays usable";
  }

  // Computes with a driver that fails on the way: an error by name, and under AUTO for what takes texture space alone.
  void expect_failure_in_the_middle(const FailingDriver &failing, pdesc_status status, const char *word) {
    if (!has_device()) GTEST_SKIP() << "no device";
    const auto expect_failure = [&](Mesh &mesh) {
      try {
        compute_on(mesh);
        ADD_FAILURE() << "nothing was thrown: " << word;
      } catch (const Error &error) {
        EXPECT_EQ(error.status(), status) << error.what();
        test::expect_one_sentence(error.what(), word);
      }
    };
    expect_failure(*mesh_on(open(test::device_backend(), failing)));
    if (test::on_card()) return; // beside which there may be no software device
    const int lose_at = script.lose_at, fail_at = script.fail_at;
    SetUp();
    script.lose_at = lose_at;
    script.fail_at = fail_at;
    const auto mesh = mesh_on(open(PDESC_BACKEND_AUTO, failing)), processor = mesh_on(open(PDESC_BACKEND_CPU, {}));
    options.buffers = 1;
    expect_failure(*mesh);
    options.buffers = 0;
    const Field field = compute_on(*mesh);
    EXPECT_EQ(field.report.backend, PDESC_BACKEND_CPU);
    EXPECT_EQ(field.warnings, "") << "the processor has not failed";
    test::expect_same_bits(field.values[0], compute_on(*processor).values[0]);
  }

  test::TestMesh ball;
  pdesc_options options;
};

// Two tiles of centers.
constexpr int first_dispatches[] = {1, 2};

TEST_F(DriverFailures, a_machine_without_the_systems_library_is_told_so) {
  const std::string word = std::string(test::driver_library) + " was not found";
  expect_refused_at_once(FailingDriver().without(test::driver_library), word.c_str());
}

TEST_F(DriverFailures, an_opengl_below_4_5_is_refused) {
  if (!has_device()) GTEST_SKIP() << "no device";
  expect_refused_at_once(FailingDriver().put("glGetIntegerv", old_version), "it offers OpenGL 3.");
  expect_refused_at_once(FailingDriver().without("glDispatchCompute"), "no glDispatchCompute");
}

TEST_F(DriverFailures, limits_below_those_of_opengl_4_5_are_refused_with_the_number) {
  if (!has_device()) GTEST_SKIP() << "no device";
  expect_refused_at_once(FailingDriver().put("glGetIntegerv", no_textures), "it takes 0 texels");
  expect_refused_at_once(FailingDriver().put("glGetIntegeri_v", one_group), "it takes 1 work groups");
  expect_refused_at_once(FailingDriver().put("glGetInteger64v", no_storage), "it takes -1 bytes");
}

TEST_F(DriverFailures, a_program_that_does_not_compile_or_link_is_an_error_of_the_device_alone) {
  expect_failure_in_the_middle(FailingDriver().put("glGetShaderiv", not_compiled), PDESC_ERROR_UNSUPPORTED, "did not compile");
  SetUp();
  expect_failure_in_the_middle(FailingDriver().put("glGetShaderiv", not_compiled).put("glGetShaderInfoLog", long_log),
                               PDESC_ERROR_UNSUPPORTED, "0:1(2): error: no; 0:3(4): error: never");
  SetUp();
  expect_failure_in_the_middle(FailingDriver().put("glGetProgramiv", not_linked), PDESC_ERROR_UNSUPPORTED, "did not link");
}

TEST_F(DriverFailures, a_device_out_of_memory_says_so_wherever_it_happens) {
  for (const int at : first_dispatches) {
    SetUp();
    script.fail_at = at;
    expect_failure_in_the_middle(FailingDriver().put("glDispatchCompute", dispatch).put("glGetError", error_status),
                                 PDESC_ERROR_OUT_OF_MEMORY, "ran out of memory");
  }
}

TEST_F(DriverFailures, a_device_lost_at_the_first_or_at_a_later_dispatch_says_so) {
  for (const int at : first_dispatches) {
    SetUp();
    script.lose_at = at;
    expect_failure_in_the_middle(FailingDriver().put("glDispatchCompute", dispatch).put("glGetGraphicsResetStatus", reset_status),
                                 PDESC_ERROR_DEVICE_LOST, "was lost");
  }
}

TEST_F(DriverFailures, a_device_that_cannot_draw_into_buffers_of_the_size_it_promised_is_left) {
  expect_failure_in_the_middle(FailingDriver().put("glCheckNamedFramebufferStatus", incomplete), PDESC_ERROR_UNSUPPORTED,
                               "cannot draw into float buffers");
}

TEST_F(DriverFailures, a_device_that_computes_nothing_is_found_out) {
  expect_failure_in_the_middle(FailingDriver().put("glDispatchCompute", dispatch_nothing), PDESC_ERROR_UNSUPPORTED,
                               "without a result");
}

TEST_F(DriverFailures, a_device_that_was_asked_for_by_name_is_opened_again_after_it_was_lost) {
  if (!has_device()) GTEST_SKIP() << "no device";
  const auto context = open(test::device_backend(),
                            FailingDriver().put("glDispatchCompute", dispatch).put("glGetGraphicsResetStatus", reset_status));
  const auto mesh = mesh_on(context);
  const std::vector<float> expected = compute_on(*mesh).values[0];
  script.dispatches = 0;
  script.lose_at = 2;
  EXPECT_THROW(compute_on(*mesh), Error);
  EXPECT_THROW(read_buffer(*mesh, "position"), Error) << "what was baked is lost";
  script.lost = false;
  test::expect_same_bits(compute_on(*mesh).values[0], expected);
  EXPECT_EQ(script.opened, 2);
}

TEST_F(DriverFailures, a_device_that_does_not_come_back_says_so_each_time) {
  if (!has_device()) GTEST_SKIP() << "no device";
  static std::atomic<bool> gone;
  gone = false;
  const DriverSubstitute sound =
      scripted(FailingDriver().put("glDispatchCompute", dispatch).put("glGetGraphicsResetStatus", reset_status));
  pdesc_context_options requested;
  pdesc_context_options_init(&requested);
  requested.backend = test::device_backend();
  const auto context = make_context(requested, [=](const char *name, void *found) {
    return gone && std::string(name) == test::driver_library ? nullptr : sound(name, found);
  });
  const auto mesh = mesh_on(context);
  script.lose_at = 1;
  EXPECT_THROW(compute_on(*mesh), Error);
  gone = true;
  for (int i = 0; i < 2; ++i) {
    try {
      compute_on(*mesh);
      FAIL() << "nothing was thrown";
    } catch (const Error &error) {
      EXPECT_EQ(error.status(), PDESC_ERROR_DEVICE_LOST);
      test::expect_one_sentence(error.what(), "does not come back");
    }
  }
}

// Under tests/sanitize.sh thread this fails if the two share the device without a lock.
TEST_F(DriverFailures, meshes_are_made_while_a_lost_device_is_opened_again) {
  if (!has_device()) GTEST_SKIP() << "no device";
  const auto context = open(test::device_backend(),
                            FailingDriver().put("glDispatchCompute", dispatch).put("glGetGraphicsResetStatus", reset_status));
  const auto mesh = mesh_on(context);
  std::atomic<bool> ended = false;
  std::thread other([&] {
    while (!ended) mesh_on(context);
  });
  for (int i = 0; i < 3; ++i) {
    script.lose_at = script.dispatches + 1;
    EXPECT_THROW(compute_on(*mesh), Error);
    script.lost = false;
    EXPECT_EQ(compute_on(*mesh).report.backend, test::device_backend());
  }
  ended = true;
  other.join();
  EXPECT_EQ(script.opened, 4);
}

TEST_F(DriverFailures, an_automatic_context_opens_its_software_device_again_after_it_was_lost) {
  if (!has(PDESC_BACKEND_SOFTWARE)) GTEST_SKIP() << "no software rasterizer";
  const auto mesh = mesh_on(
      open(PDESC_BACKEND_AUTO, FailingDriver().put("glDispatchCompute", dispatch).put("glGetGraphicsResetStatus", reset_status)));
  options.buffers = 1;
  const std::vector<float> expected = compute_on(*mesh).values[0];
  script.lose_at = script.dispatches + 2;
  EXPECT_THROW(compute_on(*mesh), Error);
  script.lost = false;
  test::expect_same_bits(compute_on(*mesh).values[0], expected);
  EXPECT_EQ(script.opened, 2);
}

TEST_F(DriverFailures, what_only_a_device_has_ends_with_the_devices_own_sentence) {
  if (!has(PDESC_BACKEND_SOFTWARE)) GTEST_SKIP() << "no software rasterizer";
  script.lose_at = 1;
  options.adaptive = 0.05;
  const auto mesh = mesh_on(
      open(PDESC_BACKEND_AUTO, FailingDriver().put("glDispatchCompute", dispatch).put("glGetGraphicsResetStatus", reset_status)));
  try {
    compute_on(*mesh);
    FAIL() << "nothing was thrown";
  } catch (const Error &error) {
    EXPECT_EQ(error.status(), PDESC_ERROR_DEVICE_LOST) << error.what();
  }
}

TEST_F(DriverFailures, a_wrong_input_or_a_cancel_leaves_what_the_mesh_keeps_on_the_device) {
  if (!has_device()) GTEST_SKIP() << "no device";
  const auto mesh = mesh_on(open(test::device_backend(), {}));
  compute_on(*mesh);
  const Session *kept = mesh->session.get();
  const std::vector<int> requested = {find_descriptor("mean_curvature")};
  EXPECT_THROW(compute(*mesh, options, requested, [](const char *, double) { return false; }), Error);
  options.radius = 17;
  EXPECT_THROW(compute_on(*mesh), Error);
  EXPECT_EQ(mesh->session.get(), kept);
}

// Why llvmpipe's own limit of 2^27 bytes is not believed.
TEST_F(DriverFailures, llvmpipe_reaches_the_end_of_a_buffer_longer_than_it_says) {
  if (!has(PDESC_BACKEND_SOFTWARE)) GTEST_SKIP() << "no software rasterizer";
  GlThread thread(true, -1);
  thread.run([](const Gl &gl, ProgramCache &programs) {
    constexpr size_t count = 40'000'000; // of 4 bytes
    Buffer buffer;
    buffer.upload(gl, nullptr, count * sizeof(GLint));
    gl.UseProgram(programs.get(gl, "end", {{GL_COMPUTE_SHADER, "end.comp.glsl"}},
                               {{"end.comp.glsl", "#version 450 core\n"
                                                  "layout(local_size_x = 1) in;\n"
                                                  "layout(std430, binding = 0) buffer All { int all[]; };\n"
                                                  "layout(location = 0) uniform int last;\n"
                                                  "void main() { all[last] = 17; }\n"}}));
    gl.Uniform1i(0, static_cast<GLint>(count - 1));
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.id());
    gl.DispatchCompute(1, 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    GLint end = 0;
    gl.GetNamedBufferSubData(buffer.id(), static_cast<GLintptr>((count - 1) * sizeof(GLint)), sizeof end, &end);
    check_gl(gl, "test");
    EXPECT_EQ(end, 17);
  });
}

} // namespace
} // namespace paradesc
