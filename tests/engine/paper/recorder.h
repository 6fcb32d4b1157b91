// A driver that remembers the programs it is given, and that may take them without compiling or computing anything.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/paper/faults.h"
#include "engine/paper/gl.h"

namespace paradesc::test {

using Program = std::map<GLenum, std::string>; // the text of each stage

// Functions of C have no state of their own, so it stands here; tests begin with begin_recording().
struct Recording {
  std::set<Program> programs;
  bool computes = true, compiles = true;
  std::map<GLuint, std::pair<GLenum, std::string>> shaders;
  std::map<GLuint, Program> attached;
};
inline Recording recording;

inline void begin_recording() { recording = {}; }

// The driver's own functions.
struct Recorded {
  PFNGLCREATESHADERPROC create = nullptr;
  PFNGLSHADERSOURCEPROC source = nullptr;
  PFNGLCOMPILESHADERPROC compile = nullptr;
  PFNGLGETSHADERIVPROC shader = nullptr;
  PFNGLATTACHSHADERPROC attach = nullptr;
  PFNGLLINKPROGRAMPROC link = nullptr;
  PFNGLGETPROGRAMIVPROC program = nullptr;
  PFNGLGETSTRINGPROC string = nullptr;
  PFNGLDISPATCHCOMPUTEPROC dispatch = nullptr;
};
inline Recorded real;

inline GLuint APIENTRY create_shader(GLenum stage) {
  const GLuint shader = real.create(stage);
  recording.shaders[shader] = {stage, ""};
  return shader;
}
inline void APIENTRY shader_text(GLuint shader, GLsizei count, const GLchar *const *strings, const GLint *lengths) {
  for (GLsizei i = 0; i < count; ++i) recording.shaders[shader].second += strings[i];
  if (recording.compiles) real.source(shader, count, strings, lengths);
}
inline void APIENTRY compile_shader(GLuint shader) {
  if (recording.compiles) real.compile(shader);
}
inline void APIENTRY shader_status(GLuint shader, GLenum name, GLint *value) {
  if (recording.compiles) return real.shader(shader, name, value);
  *value = GL_TRUE;
}
inline void APIENTRY attach_shader(GLuint program, GLuint shader) {
  const auto &[stage, text] = recording.shaders[shader];
  recording.attached[program][stage] = text;
  real.attach(program, shader);
}
inline void APIENTRY link_program(GLuint program) {
  recording.programs.insert(std::exchange(recording.attached[program], {}));
  if (recording.compiles) real.link(program);
}
inline void APIENTRY program_status(GLuint program, GLenum name, GLint *value) {
  if (recording.compiles) return real.program(program, name, value);
  *value = GL_TRUE;
}
inline void APIENTRY dispatch_or_not(GLuint x, GLuint y, GLuint z) {
  if (recording.computes) real.dispatch(x, y, z);
}
inline const GLubyte *APIENTRY card_name(GLenum name) {
  return name == GL_RENDERER ? reinterpret_cast<const GLubyte *>("Pretended card") : real.string(name);
}
inline const char *no_device_extensions(void *, int32_t) { return ""; }

// pretended: the software rasterizer shows itself as a graphics card, which has larger work groups.
inline DriverSubstitute recording_driver(bool pretended) {
  FailingDriver driver;
  driver.put("glCreateShader", create_shader).put("glShaderSource", shader_text).put("glCompileShader", compile_shader);
  driver.put("glGetShaderiv", shader_status).put("glAttachShader", attach_shader).put("glLinkProgram", link_program);
  driver.put("glGetProgramiv", program_status).put("glDispatchCompute", dispatch_or_not);
  if (pretended) driver.put("glGetString", card_name).put("eglQueryDeviceStringEXT", no_device_extensions);
  return [put = DriverSubstitute(driver)](const char *name, void *found) {
    const std::string requested = name;
    auto keep = [&](const char *wanted, auto &function) {
      if (requested == wanted) function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
    };
    keep("glCreateShader", real.create);
    keep("glShaderSource", real.source);
    keep("glCompileShader", real.compile);
    keep("glGetShaderiv", real.shader);
    keep("glAttachShader", real.attach);
    keep("glLinkProgram", real.link);
    keep("glGetProgramiv", real.program);
    keep("glGetString", real.string);
    keep("glDispatchCompute", real.dispatch);
    return put(name, found);
  };
}

} // namespace paradesc::test
