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
    small.limits.texture_size = 2;
    const std::vector<vec4> elements(2 * LIST_ROW + 1, vec4(0.0f));
    const auto expect_refused = [&](size_t max_bytes, int32_t status, const auto &upload) {
      upload(max_bytes);
      try {
        upload(max_bytes + 1);
        FAIL() << "nothing was thrown";
      } catch (const Error &error) {
        EXPECT_EQ(error.status(), status);
        test::expect_one_sentence(error.what(), std::to_string(max_bytes + 1));
      }
    };
    BufferTexture buffer;
    expect_refused(16, PDESC_ERROR_UNSUPPORTED,
                   [&](size_t count) { buffer.upload(small, GL_RGBA32F, std::vector<vec4>(count), GL_STATIC_DRAW); });
    ListTexture texture;
    expect_refused(2 * LIST_ROW, PDESC_ERROR_OUT_OF_MEMORY,
                   [&](size_t count) { texture.upload(small, GL_RGBA32F, elements.data(), count); });
    check_gl(gl, "test");
  });
}

} // namespace
} // namespace paradesc
