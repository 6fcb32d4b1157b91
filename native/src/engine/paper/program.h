// Embedded shader files → compiled programs, each assembled, compiled and linked once per context.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "engine/paper/gl.h"

namespace paradesc {

struct EmbeddedShader {
  const char *path; // below shaders/
  const char *text;
};
const std::vector<EmbeddedShader> &embedded_shaders();

// The text of one embedded file, with #include lines resolved and #line directives set. generated: texts of includes that are
// made at run time, by name.
std::string shader_source(const std::string &path, const std::map<std::string, std::string> &generated);

// One #define of a text that is made at run time: a compile-time choice, 1 or 0, or a number.
std::string define(const char *name, int value);

struct ShaderStage {
  GLenum type;
  std::string path;
};

class ProgramCache {
public:
  // name: distinguishes programs of the same files. Only the most recently requested programs are kept: each takes half a
  // megabyte, and a context may live as long as its host. Throws Error(UNSUPPORTED) with the driver's log.
  GLuint get(const Gl &gl, const std::string &name, const std::vector<ShaderStage> &stages,
             const std::map<std::string, std::string> &generated = {});
  GLuint find(const std::string &name); // 0: the program is not kept
  void clear() { programs_.clear(); }   // for a context that is about to be destroyed, with its programs

private:
  static constexpr size_t max_programs_ = 32;
  struct Program {
    GLuint id;
    uint64_t last_call; // the number of the call that returned it last
  };
  std::map<std::string, Program> programs_;
  uint64_t calls_ = 0;
};

} // namespace paradesc
