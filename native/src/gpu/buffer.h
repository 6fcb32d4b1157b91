// OpenGL buffers, textures and vertex arrays that delete themselves; made and destroyed on the GL thread only.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "gpu/gl.h"
#include "support/math.h"

namespace paradesc {

class Buffer {
public:
  Buffer() = default;
  Buffer(Buffer &&other) noexcept { swap(other); }
  Buffer &operator=(Buffer &&other) noexcept {
    swap(other);
    return *this;
  }
  ~Buffer() {
    if (id_) gl_->DeleteBuffers(1, &id_);
  }
  // Replaces the content; bytes may be 0, which keeps a valid buffer. Throws Error(OUT_OF_MEMORY) where shaders could not reach
  // all of it.
  void upload(const Gl &gl, const void *data, size_t bytes, GLenum usage = GL_STATIC_DRAW);
  template <class T> void upload(const Gl &gl, const std::vector<T> &data, GLenum usage = GL_STATIC_DRAW) {
    upload(gl, data.data(), data.size() * sizeof(T), usage);
  }
  GLuint id() const { return id_; }

private:
  void swap(Buffer &other) {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
  }
  const Gl *gl_ = nullptr;
  GLuint id_ = 0;
};

// A long list that shaders fetch from as a texture: software devices gather that by vectors, and loads from storage buffers one
// by one.
class BufferTexture {
public:
  BufferTexture() = default;
  BufferTexture(BufferTexture &&other) noexcept { swap(other); }
  BufferTexture &operator=(BufferTexture &&other) noexcept {
    swap(other);
    return *this;
  }
  ~BufferTexture() {
    if (id_) gl_->DeleteTextures(1, &id_);
  }
  // Pairs of integers (GL_RG32I).
  void upload(const Gl &gl, const std::vector<ivec2> &pairs, GLenum usage = GL_STATIC_DRAW);
  GLuint id() const { return id_; }

private:
  void swap(BufferTexture &other) {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
    std::swap(buffer_, other.buffer_);
  }
  const Gl *gl_ = nullptr;
  GLuint id_ = 0;
  Buffer buffer_;
};

// A 2-D texture without mipmaps, fetched nearest.
class Texture {
public:
  Texture() = default;
  Texture(const Gl &gl, int width, int height, GLenum format);
  Texture(Texture &&other) noexcept { swap(other); }
  Texture &operator=(Texture &&other) noexcept {
    swap(other);
    return *this;
  }
  ~Texture() {
    if (id_) gl_->DeleteTextures(1, &id_);
  }
  GLuint id() const { return id_; }

private:
  void swap(Texture &other) {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
  }
  const Gl *gl_ = nullptr;
  GLuint id_ = 0;
};

// A long list in a 2-D texture, element i at (i % ROW, i / ROW): fetches from textures are gathered by the vector units of
// software rasterizers, divergent loads from storage buffers are not.
class ListTexture {
public:
  // elements: of `channels` floats (format GL_RGBA32F, GL_R32F) or ints (GL_RGBA32I, GL_RG32I, GL_R32I); the texture is kept
  // while the size fits.
  void upload(const Gl &gl, GLenum format, const void *elements, size_t count);
  GLuint id() const { return texture_.id(); }

private:
  Texture texture_;
  size_t rows_ = 0;
  std::vector<std::byte> staging_;
};

} // namespace paradesc
