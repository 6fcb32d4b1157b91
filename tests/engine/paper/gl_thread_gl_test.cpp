// Work on the GL thread: exceptions, several threads, refusals in one sentence; programs and their texts.
#include "engine/paper/gl_thread.h"

#include <algorithm>
#include <atomic>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "engine/paper/buffer.h"
#include "support/error.h"
#include "support/on_device.h"

namespace paradesc {
namespace {

using OnGlThread = test::OnDevice;

size_t occurrences(const std::string &text, const std::string &word) {
  size_t count = 0;
  for (size_t i = text.find(word); i != std::string::npos; i = text.find(word, i + 1)) ++count;
  return count;
}

TEST_F(OnGlThread, exceptions_cross_to_the_caller_and_the_thread_stays_usable) {
  for (int i = 0; i < 3; ++i) {
    try {
      thread->run([](const Gl &, ProgramCache &) { throw Error(PDESC_ERROR_CANCELLED, "Enough."); });
      FAIL() << "nothing was thrown";
    } catch (const Error &error) {
      EXPECT_EQ(error.status(), PDESC_ERROR_CANCELLED);
      EXPECT_STREQ(error.what(), "Enough.");
    }
    EXPECT_THROW(thread->run([](const Gl &, ProgramCache &) { throw std::out_of_range("other types, too"); }), std::out_of_range);
    bool ran = false;
    thread->run([&](const Gl &, ProgramCache &) { ran = true; });
    EXPECT_TRUE(ran);
  }
}

TEST_F(OnGlThread, all_work_runs_on_one_thread_that_is_not_the_callers) {
  std::thread::id first, second;
  thread->run([&](const Gl &, ProgramCache &) { first = std::this_thread::get_id(); });
  std::jthread([&] { thread->run([&](const Gl &, ProgramCache &) { second = std::this_thread::get_id(); }); }).join();
  EXPECT_EQ(first, second);
  EXPECT_NE(first, std::this_thread::get_id());
}

TEST_F(OnGlThread, callers_of_one_thread_take_turns) {
  std::atomic<int> inside{0};
  std::atomic<bool> together{false};
  int sum = 0; // unguarded: turns are enough
  {
    std::vector<std::jthread> callers;
    for (int i = 0; i < 4; ++i)
      callers.emplace_back([&] {
        for (int k = 0; k < 50; ++k)
          thread->run([&](const Gl &, ProgramCache &) {
            if (++inside != 1) together = true;
            ++sum;
            --inside;
          });
      });
  }
  EXPECT_FALSE(together);
  EXPECT_EQ(sum, 200);
}

TEST_F(OnGlThread, two_threads_work_at_once_without_sharing_objects) {
  GlThread other(!test::on_card(), -1);
  const auto work = [](GlThread &on, int32_t value, std::vector<int32_t> &read) {
    for (int k = 0; k < 20; ++k)
      on.run([&](const Gl &gl, ProgramCache &) {
        Buffer buffer;
        buffer.upload(gl, std::vector<int32_t>(4096, value));
        read.assign(4096, -1);
        gl.GetNamedBufferSubData(buffer.id(), 0, 4096 * sizeof(int32_t), read.data());
        check_gl(gl, "test");
      });
  };
  std::vector<int32_t> read_here, read_there;
  {
    std::jthread here([&] { work(*thread, 1, read_here); });
    std::jthread there([&] { work(other, 2, read_there); });
  }
  EXPECT_EQ(read_here, std::vector<int32_t>(4096, 1));
  EXPECT_EQ(read_there, std::vector<int32_t>(4096, 2));
}

TEST_F(OnGlThread, a_device_has_a_name_and_a_core_context_of_at_least_4_5) {
  EXPECT_FALSE(thread->device().empty());
  std::string version;
  thread->run([&](const Gl &gl, ProgramCache &) {
    GLint major = 0, minor = 0;
    gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    EXPECT_GE(10 * major + minor, 45);
    version = reinterpret_cast<const char *>(gl.GetString(GL_VERSION));
  });
  std::cout << "device: " << thread->device() << ", OpenGL " << version << std::endl; // drivers.py reads it
}

TEST_F(OnGlThread, a_program_that_does_not_compile_names_its_file_and_line) {
  const std::map<std::string, std::string> generated{
      {"broken.comp.glsl", "#version 450 core\n#include \"part.glsl\"\nvoid main() {}\n"},
      {"part.glsl", "// fine\nint wrong = = 3;\n"}};
  try {
    thread->run([&](const Gl &gl, ProgramCache &programs) {
      programs.get(gl, "broken", {{GL_COMPUTE_SHADER, "broken.comp.glsl"}}, generated);
    });
    FAIL() << "nothing was thrown";
  } catch (const Error &error) {
    const std::string text = error.what();
    EXPECT_EQ(error.status(), PDESC_ERROR_UNSUPPORTED);
    EXPECT_NE(text.find("broken.comp.glsl"), std::string::npos) << text;
    EXPECT_NE(text.find("1: part.glsl"), std::string::npos) << text;
    EXPECT_TRUE(text.find("1:2") != std::string::npos || text.find("1(2)") != std::string::npos)
        << text << "\nfile 1, line 2, as Mesa or NVIDIA writes it; in errors of meaning Mesa drops the file";
  }
}

TEST_F(OnGlThread, a_program_is_made_once) {
  const std::map<std::string, std::string> generated{
      {"empty.comp.glsl", "#version 450 core\nlayout(local_size_x = 1) in;\nvoid main() {}\n"}};
  thread->run([&](const Gl &gl, ProgramCache &programs) {
    const GLuint first = programs.get(gl, "empty", {{GL_COMPUTE_SHADER, "empty.comp.glsl"}}, generated);
    EXPECT_EQ(programs.get(gl, "empty", {{GL_COMPUTE_SHADER, "empty.comp.glsl"}}, generated), first);
    EXPECT_NE(programs.get(gl, "another", {{GL_COMPUTE_SHADER, "empty.comp.glsl"}}, generated), first);
  });
}

TEST_F(OnGlThread, of_many_programs_those_asked_for_last_are_kept) {
  const std::map<std::string, std::string> generated{
      {"empty.comp.glsl", "#version 450 core\nlayout(local_size_x = 1) in;\nvoid main() {}\n"}};
  thread->run([&](const Gl &gl, ProgramCache &programs) {
    const auto get = [&](const std::string &name) {
      return programs.get(gl, name, {{GL_COMPUTE_SHADER, "empty.comp.glsl"}}, generated);
    };
    const GLuint first = get("first"), often = get("often");
    bool name_given_again = false;
    for (int i = 0; i < 40; ++i) {
      name_given_again |= get("program " + std::to_string(i)) == first;
      EXPECT_EQ(get("often"), often);
    }
    GLint linked = 0;
    gl.GetProgramiv(often, GL_LINK_STATUS, &linked);
    EXPECT_TRUE(linked);
    EXPECT_EQ(gl.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    gl.GetProgramiv(first, GL_LINK_STATUS, &linked);
    EXPECT_TRUE(name_given_again || gl.GetError() != GL_NO_ERROR) << "the first program is still there";
  });
}

TEST_F(OnGlThread, an_error_of_opengl_is_an_exception_with_the_stage) {
  try {
    thread->run([](const Gl &gl, ProgramCache &) {
      gl.Enable(0xdead);
      check_gl(gl, "invented");
    });
    FAIL() << "nothing was thrown";
  } catch (const Error &error) {
    EXPECT_NE(std::string(error.what()).find("stage invented"), std::string::npos) << error.what();
  }
}

TEST_F(OnGlThread, a_device_of_too_high_an_index_is_refused) {
  try {
    GlThread(!test::on_card(), 999);
    FAIL() << "nothing was thrown";
  } catch (const Error &error) {
    EXPECT_EQ(error.status(), PDESC_ERROR_UNSUPPORTED);
    EXPECT_NE(std::string(error.what()).find("999"), std::string::npos) << error.what();
  }
}

TEST(GlThread, a_hardware_device_where_there_is_none_is_refused_in_one_sentence) {
  try {
    const GlThread thread(false, -1);
    GTEST_SKIP() << "There is one: " << thread.device();
  } catch (const Error &error) {
    const std::string text = error.what();
    EXPECT_EQ(error.status(), PDESC_ERROR_UNSUPPORTED);
    ASSERT_FALSE(text.empty());
    EXPECT_EQ(text.back(), '.');
    EXPECT_EQ(occurrences(text, ". "), 0u) << text;
    EXPECT_EQ(occurrences(text, "\n"), 0u) << text;
    EXPECT_NE(text.find("backend"), std::string::npos) << text << "\nsays what to do";
  }
}

TEST(ShaderSource, a_file_is_included_once_however_often_it_is_named) {
  const std::string source =
      shader_source("main.glsl", {{"main.glsl", "#version 450\n#include \"a.glsl\"\n#include \"b.glsl\"\nint last;\n"},
                                  {"a.glsl", "#include \"c.glsl\"\nint of_a;\n"},
                                  {"b.glsl", "#include \"c.glsl\"\nint of_b;\n"},
                                  {"c.glsl", "int of_c;\n"}});
  for (const char *line : {"int of_a;", "int of_b;", "int of_c;", "int last;"})
    EXPECT_EQ(occurrences(source, line), 1u) << source;
  EXPECT_LT(source.find("of_c"), source.find("of_a"));
  EXPECT_EQ(source.find("#include"), std::string::npos);
  EXPECT_TRUE(source.starts_with("#version")) << "nothing may stand before it";
  EXPECT_NE(source.find("#line 4 0\nint last;"), std::string::npos) << source;
}

TEST(ShaderSource, every_embedded_file_is_there) {
  ASSERT_FALSE(embedded_shaders().empty());
  EXPECT_TRUE(
      std::ranges::any_of(embedded_shaders(), [](const EmbeddedShader &file) { return std::string(file.path) == "shared.h"; }));
  try {
    (void)shader_source("nowhere.glsl", {});
    FAIL() << "nothing was thrown";
  } catch (const Error &error) {
    EXPECT_NE(std::string(error.what()).find("nowhere.glsl"), std::string::npos);
  }
}

} // namespace
} // namespace paradesc
