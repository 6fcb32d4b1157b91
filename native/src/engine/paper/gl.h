// The OpenGL 4.5 entry points that the library uses, as members: no global function pointers that a host could share.
#pragma once

#include <GL/glcorearb.h>

#define PARADESC_GL_FUNCTIONS(F)                                                                                                 \
  F(PFNGLGETERRORPROC, GetError)                                                                                                 \
  F(PFNGLGETSTRINGPROC, GetString)                                                                                               \
  F(PFNGLGETGRAPHICSRESETSTATUSPROC, GetGraphicsResetStatus)                                                                     \
  F(PFNGLGETINTEGERVPROC, GetIntegerv)                                                                                           \
  F(PFNGLGETINTEGERI_VPROC, GetIntegeri_v)                                                                                       \
  F(PFNGLGETINTEGER64VPROC, GetInteger64v)                                                                                       \
  F(PFNGLENABLEPROC, Enable)                                                                                                     \
  F(PFNGLDISABLEPROC, Disable)                                                                                                   \
  F(PFNGLVIEWPORTPROC, Viewport)                                                                                                 \
  F(PFNGLSCISSORPROC, Scissor)                                                                                                   \
  F(PFNGLDEPTHFUNCPROC, DepthFunc)                                                                                               \
  F(PFNGLDEPTHMASKPROC, DepthMask)                                                                                               \
  F(PFNGLBLENDFUNCPROC, BlendFunc)                                                                                               \
  F(PFNGLFINISHPROC, Finish)                                                                                                     \
  F(PFNGLFLUSHPROC, Flush)                                                                                                       \
  F(PFNGLDRAWARRAYSPROC, DrawArrays)                                                                                             \
  F(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                                                                                       \
  F(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)                                                                                   \
  F(PFNGLBINDBUFFERPROC, BindBuffer)                                                                                             \
  F(PFNGLCREATEBUFFERSPROC, CreateBuffers)                                                                                       \
  F(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                                                                       \
  F(PFNGLNAMEDBUFFERDATAPROC, NamedBufferData)                                                                                   \
  F(PFNGLNAMEDBUFFERSUBDATAPROC, NamedBufferSubData)                                                                             \
  F(PFNGLGETNAMEDBUFFERSUBDATAPROC, GetNamedBufferSubData)                                                                       \
  F(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                                                                                     \
  F(PFNGLCREATETEXTURESPROC, CreateTextures)                                                                                     \
  F(PFNGLDELETETEXTURESPROC, DeleteTextures)                                                                                     \
  F(PFNGLTEXTURESTORAGE2DPROC, TextureStorage2D)                                                                                 \
  F(PFNGLTEXTURESUBIMAGE2DPROC, TextureSubImage2D)                                                                               \
  F(PFNGLTEXTUREPARAMETERIPROC, TextureParameteri)                                                                               \
  F(PFNGLTEXTUREBUFFERPROC, TextureBuffer)                                                                                       \
  F(PFNGLGETTEXTUREIMAGEPROC, GetTextureImage)                                                                                   \
  F(PFNGLBINDTEXTUREUNITPROC, BindTextureUnit)                                                                                   \
  F(PFNGLBINDIMAGETEXTUREPROC, BindImageTexture)                                                                                 \
  F(PFNGLCREATEFRAMEBUFFERSPROC, CreateFramebuffers)                                                                             \
  F(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                                                                             \
  F(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                                                                   \
  F(PFNGLNAMEDFRAMEBUFFERTEXTUREPROC, NamedFramebufferTexture)                                                                   \
  F(PFNGLNAMEDFRAMEBUFFERDRAWBUFFERSPROC, NamedFramebufferDrawBuffers)                                                           \
  F(PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC, CheckNamedFramebufferStatus)                                                           \
  F(PFNGLCLEARNAMEDBUFFERDATAPROC, ClearNamedBufferData)                                                                         \
  F(PFNGLCLEARNAMEDFRAMEBUFFERFVPROC, ClearNamedFramebufferfv)                                                                   \
  F(PFNGLCLEARNAMEDFRAMEBUFFERIVPROC, ClearNamedFramebufferiv)                                                                   \
  F(PFNGLCREATEVERTEXARRAYSPROC, CreateVertexArrays)                                                                             \
  F(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                                                                             \
  F(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                                                   \
  F(PFNGLCREATESHADERPROC, CreateShader)                                                                                         \
  F(PFNGLDELETESHADERPROC, DeleteShader)                                                                                         \
  F(PFNGLSHADERSOURCEPROC, ShaderSource)                                                                                         \
  F(PFNGLCOMPILESHADERPROC, CompileShader)                                                                                       \
  F(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                                           \
  F(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                                                 \
  F(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                                                       \
  F(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                                                                       \
  F(PFNGLATTACHSHADERPROC, AttachShader)                                                                                         \
  F(PFNGLLINKPROGRAMPROC, LinkProgram)                                                                                           \
  F(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                                                         \
  F(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                                                               \
  F(PFNGLGETPROGRAMRESOURCEINDEXPROC, GetProgramResourceIndex)                                                                   \
  F(PFNGLGETPROGRAMRESOURCEIVPROC, GetProgramResourceiv)                                                                         \
  F(PFNGLUSEPROGRAMPROC, UseProgram)                                                                                             \
  F(PFNGLUNIFORM1FPROC, Uniform1f)                                                                                               \
  F(PFNGLUNIFORM1IPROC, Uniform1i)

namespace paradesc {

// The limits that the device reports; never less than OpenGL 4.5 promises, see GlContext.
struct GlLimits {
  GLint texture_size = 16384;
  GLint list_texels = 65536;       // of a buffer texture
  GLint work_groups = 65535;       // along x
  GLint64 storage_bytes = 1 << 27; // of one storage buffer
  // Invocations of a work group. Cards run 32 or 64 side by side and idle if a group has fewer. Software devices give each core a
  // row of groups; small groups balance these rows.
  int group_size = 64;
};

struct Gl {
#define PARADESC_MEMBER(type, name) type name = nullptr;
  PARADESC_GL_FUNCTIONS(PARADESC_MEMBER)
#undef PARADESC_MEMBER
  GlLimits limits;
};

// The number of work groups for so many invocations.
inline GLuint group_count(const Gl &gl, int invocations) {
  return static_cast<GLuint>((invocations + gl.limits.group_size - 1) / gl.limits.group_size);
}

// The number of invocations rounded up to whole work groups.
inline size_t in_whole_groups(const Gl &gl, size_t invocations) {
  const auto group = static_cast<size_t>(gl.limits.group_size);
  return (invocations + group - 1) / group * group;
}

// Throws Error with the stage's name if OpenGL has recorded an error: DEVICE_LOST, OUT_OF_MEMORY, else UNKNOWN. Clears all
// recorded errors.
void check_gl(const Gl &gl, const char *stage);

} // namespace paradesc
