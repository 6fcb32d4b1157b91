// Arrays in memory → storage buffers and textures on the device.
#include "engine/paper/buffer.h"

#include <algorithm>

#include "support/error.h"
#include "support/math.h"

#include "shared.h"

namespace paradesc {

// Checks the size first, because beyond the limit shaders would read zeros and no error would be reported.
static void check_storage(const Gl &gl, size_t bytes) {
  if (bytes > static_cast<size_t>(gl.limits.storage_bytes))
    throw Error(PDESC_ERROR_OUT_OF_MEMORY, "The mesh is too large for this device (a list of " + std::to_string(bytes >> 20) +
                                               " MiB, of which it takes " + std::to_string(gl.limits.storage_bytes >> 20) +
                                               "); use the software or reference backend.");
}

void Buffer::upload(const Gl &gl, const void *data, size_t bytes, GLenum usage) {
  check_storage(gl, bytes);
  fill(gl, data, bytes, usage);
}

void Buffer::reserve(const Gl &gl, size_t bytes, GLenum usage) {
  if (id() && bytes <= reserved_ && reserved_ / 4 <= bytes) return;
  upload(gl, nullptr, bytes, usage);
  reserved_ = bytes;
}

void Buffer::repeat(const Gl &gl, uint32_t word, size_t count, GLenum usage) {
  reserve(gl, count * sizeof word, usage);
  gl.ClearNamedBufferData(id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &word);
}

void Buffer::fill(const Gl &gl, const void *data, size_t bytes, GLenum usage) {
  if (!id()) {
    GLuint made = 0;
    gl.CreateBuffers(1, &made);
    name_ = {gl, made};
  }
  reserved_ = 0;
  // An empty buffer cannot be bound for storage; one element keeps every binding valid.
  const size_t size = std::max<size_t>(bytes, 16);
  gl.NamedBufferData(id(), static_cast<GLsizeiptr>(size), bytes >= size ? data : nullptr, usage);
  if (data && bytes && bytes < size) gl.NamedBufferSubData(id(), 0, static_cast<GLsizeiptr>(bytes), data);
}

void BufferTexture::upload(const Gl &gl, GLenum format, const void *data, size_t bytes, GLenum usage) {
  const size_t texels = bytes / (format == GL_RGBA32F || format == GL_RGBA32I ? sizeof(vec4) : sizeof(vec2));
  if (texels > static_cast<size_t>(gl.limits.list_texels))
    throw Error(PDESC_ERROR_UNSUPPORTED, "The mesh is too large for this device (" + std::to_string(texels) +
                                             " list elements); use the reference backend.");
  buffer_.fill(gl, data, bytes, usage);
  if (id()) return;
  GLuint made = 0;
  gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &made);
  name_ = {gl, made};
  gl.TextureBuffer(id(), format, buffer_.id());
}

Texture::Texture(const Gl &gl, int width, int height, GLenum format) {
  GLuint made = 0;
  gl.CreateTextures(GL_TEXTURE_2D, 1, &made);
  name_ = {gl, made};
  gl.TextureStorage2D(made, 1, format, width, height);
  gl.TextureParameteri(made, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TextureParameteri(made, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

} // namespace paradesc
