// Buffers and lists on a device: what is beyond its limits is refused, and what has room is not made again.
#include "engine/paper/buffer.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/paper/gl_thread.h"
#include "shared.h"
#include "support/on_device.h"
#include "support/sentence.h"

namespace paradesc {
namespace {

class Buffers : public test::OnDevice {};

TEST_F(Buffers, a_buffer_beyond_what_shaders_reach_is_refused) {
  thread->run([](const Gl &gl, ProgramCache &) {
    Gl small = gl;
    small.limits.storage_bytes = 1 << 20;
    Buffer buffer;
    buffer.upload(small, nullptr, 1 << 20);
    try {
      buffer.upload(small, nullptr, (1 << 20) + 4);
      FAIL() << "nothing was thrown";
    } catch (const Error &error) {
      EXPECT_EQ(error.status(), PDESC_ERROR_OUT_OF_MEMORY);
      test::expect_one_sentence(error.what(), "1 MiB");
    }
    check_gl(gl, "test");
  });
}

// Functions of C have no state of their own.
std::vector<GLsizeiptr> stores_made;
PFNGLNAMEDBUFFERDATAPROC real_store = nullptr;
void APIENTRY noted_store(GLuint buffer, GLsizeiptr size, const void *data, GLenum usage) {
  stores_made.push_back(size);
  real_store(buffer, size, data, usage);
}

TEST_F(Buffers, room_is_kept_until_it_is_too_small_or_far_too_large) {
  thread->run([](const Gl &gl, ProgramCache &) {
    Gl noted = gl;
    real_store = gl.NamedBufferData;
    noted.NamedBufferData = noted_store;
    stores_made.clear();
    Buffer buffer;
    const std::vector<uint32_t> content(100, 0);
    for (const size_t bytes : {0, 0, 4000, 1000, 4000, 999, 1000}) buffer.reserve(noted, bytes);
    buffer.upload(noted, content);
    buffer.reserve(noted, 400);
    EXPECT_EQ(stores_made, (std::vector<GLsizeiptr>{16, 4000, 999, 1000, 400, 400}));
    check_gl(gl, "test");
  });
}

TEST_F(Buffers, a_list_beyond_the_devices_textures_is_refused_with_its_length) {
  thread->run([](const Gl &gl, ProgramCache &) {
    Gl small = gl;
    small.limits.list_texels = 16;
    for (const auto &[format, floats] : {std::pair(GL_RGBA32F, 4), std::pair(GL_RG32F, 2)}) {
      BufferTexture list;
      list.upload(small, static_cast<GLenum>(format), std::vector<float>(16 * floats), GL_STATIC_DRAW);
      try {
        list.upload(small, static_cast<GLenum>(format), std::vector<float>(17 * floats), GL_STATIC_DRAW);
        FAIL() << "nothing was thrown";
      } catch (const Error &error) {
        EXPECT_EQ(error.status(), PDESC_ERROR_UNSUPPORTED);
        test::expect_one_sentence(error.what(), "17");
      }
    }
    check_gl(gl, "test");
  });
}

} // namespace
} // namespace paradesc
