// OpenGL buffers, textures and vertex arrays that delete themselves; made and destroyed on the GL thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engine/paper/gl.h"
#include "support/math.h"

namespace paradesc {

// The name of one OpenGL object; Delete is the entry point that deletes it.
template <auto Delete> class GlName {
public:
  GlName() = default;
  GlName(const Gl &gl, GLuint id) : gl_(&gl), id_(id) {}
  GlName(GlName &&other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}
  GlName &operator=(GlName &&other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
    return *this;
  }
  ~GlName() {
    if (id_) (gl_->*Delete)(1, &id_);
  }
  GLuint id() const { return id_; }

private:
  const Gl *gl_ = nullptr;
  GLuint id_ = 0;
};

class Buffer {
public:
  // Replaces the content; bytes may be 0, which keeps a valid buffer. Throws Error(OUT_OF_MEMORY) if shaders cannot reach all of
  // the content.
  void upload(const Gl &gl, const void *data, size_t bytes, GLenum usage = GL_STATIC_DRAW);
  template <class T> void upload(const Gl &gl, const std::vector<T> &data, GLenum usage = GL_STATIC_DRAW) {
    upload(gl, data.data(), data.size() * sizeof(T), usage);
  }
  // Makes room for bytes that shaders write. Keeps the storage unless it is far too large. Throws as upload does.
  void reserve(const Gl &gl, size_t bytes, GLenum usage = GL_STREAM_COPY);
  // Makes room for `count` 32-bit words and sets each of them to `word`.
  void repeat(const Gl &gl, uint32_t word, size_t count, GLenum usage);
  // Uploads content that shaders do not read as storage.
  void fill(const Gl &gl, const void *data, size_t bytes, GLenum usage);
  GLuint id() const { return name_.id(); }

private:
  GlName<&Gl::DeleteBuffers> name_;
  size_t reserved_ = 0; // bytes; 0: the content was uploaded
};

// A long list that shaders fetch from as a texture. Software devices gather such fetches with vector instructions, but load from
// storage buffers one element at a time.
class BufferTexture {
public:
  // Elements are a whole number of texels. These have the format GL_RGBA32F, GL_RGBA32I, GL_RG32F or GL_RG32I, always the same.
  void upload(const Gl &gl, GLenum format, const auto &list, GLenum usage) {
    const std::span elements(list.begin(), list.end());
    upload(gl, format, elements.data(), elements.size_bytes(), usage);
  }
  GLuint id() const { return name_.id(); }

private:
  void upload(const Gl &gl, GLenum format, const void *data, size_t bytes, GLenum usage);

  Buffer buffer_;
  GlName<&Gl::DeleteTextures> name_;
};

// A 2-D texture without mipmaps, fetched nearest.
class Texture {
public:
  Texture() = default;
  Texture(const Gl &gl, int width, int height, GLenum format);
  GLuint id() const { return name_.id(); }

private:
  GlName<&Gl::DeleteTextures> name_;
};

} // namespace paradesc
