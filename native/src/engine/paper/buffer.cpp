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
  const size_t texels = bytes / sizeof(vec4);
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

void ListTexture::upload(const Gl &gl, GLenum format, const void *elements, size_t count) {
  const bool integer = format == GL_RGBA32I || format == GL_RG32I || format == GL_R32I;
  const size_t channels = format == GL_RGBA32F || format == GL_RGBA32I ? 4 : format == GL_RG32F || format == GL_RG32I ? 2 : 1;
  const GLenum floats = channels == 4 ? GL_RGBA : channels == 2 ? GL_RG : GL_RED;
  const GLenum integers = channels == 4 ? GL_RGBA_INTEGER : channels == 2 ? GL_RG_INTEGER : GL_RED_INTEGER;
  const size_t rows = std::max<size_t>(1, (count + LIST_ROW - 1) / LIST_ROW);
  if (rows > static_cast<size_t>(gl.limits.texture_size))
    throw Error(PDESC_ERROR_OUT_OF_MEMORY, "The mesh is too large for this device (a list of " + std::to_string(count) +
                                               " elements); use the reference backend.");
  if (rows != rows_) texture_ = Texture(gl, LIST_ROW, static_cast<int>(rows), format);
  rows_ = rows;
  // Sends the whole rows, then the rest.
  const size_t whole = count / LIST_ROW, rest = count % LIST_ROW;
  const auto send = [&](size_t first_row, size_t width, size_t height) {
    if (width * height == 0) return;
    gl.TextureSubImage2D(texture_.id(), 0, 0, static_cast<GLint>(first_row), static_cast<GLsizei>(width),
                         static_cast<GLsizei>(height), integer ? integers : floats, integer ? GL_INT : GL_FLOAT,
                         static_cast<const std::byte *>(elements) + first_row * LIST_ROW * channels * 4);
  };
  send(0, LIST_ROW, whole);
  send(whole, rest, 1);
}

} // namespace paradesc
