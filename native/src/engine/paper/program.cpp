// Shader texts with #include → linked OpenGL programs; driver messages name our files.
#include "engine/paper/program.h"

#include <algorithm>
#include <sstream>

#include "support/error.h"

namespace paradesc {

static std::string find_text(const std::string &path, const std::map<std::string, std::string> &generated) {
  if (const auto found = generated.find(path); found != generated.end()) return found->second;
  for (const EmbeddedShader &file : embedded_shaders())
    if (path == file.path) return file.text;
  throw Error(PDESC_ERROR_UNKNOWN, "Shader file " + path + " was not built into the library; rebuild it.");
}

// GLSL numbers its sources: the number of a file is its index in `files`, by which the error message names it.
static void append_source(const std::string &path, const std::map<std::string, std::string> &generated,
                          std::vector<std::string> &files, std::string &source) {
  for (const std::string &known : files)
    if (known == path) return;
  const size_t number = files.size();
  files.push_back(path);
  std::istringstream text(find_text(path, generated));
  std::string line;
  bool after_include = number > 0;
  for (int row = 1; std::getline(text, line); ++row) {
    if (line.starts_with("#include \"")) {
      append_source(line.substr(10, line.rfind('"') - 10), generated, files, source);
      after_include = true;
      continue;
    }
    if (after_include) source += "#line " + std::to_string(row) + " " + std::to_string(number) + "\n";
    after_include = false;
    source += line + "\n";
  }
}

std::string define(const char *name, int value) { return std::string("#define ") + name + " " + std::to_string(value) + "\n"; }

std::string shader_source(const std::string &path, const std::map<std::string, std::string> &generated) {
  std::vector<std::string> files;
  std::string source;
  append_source(path, generated, files, source);
  // Drivers name a file by its number.
  for (size_t i = 0; i < files.size(); ++i) source += "// " + std::to_string(i) + ": " + files[i] + "\n";
  return source;
}

// "0: a.glsl, 1: b.glsl" from the comments that shader_source leaves at the end.
static std::string file_list(const std::string &source) {
  std::istringstream text(source.substr(source.rfind("// 0: ")));
  std::string list, line;
  while (std::getline(text, line)) list += (list.empty() ? "" : ", ") + line.substr(3);
  return list;
}

// A driver's log as the end of one sentence: its lines are joined, and cut if they are too long.
static std::string one_line(const char *log) {
  constexpr size_t max_length = 600;
  std::string text;
  for (const char *c = log; *c && text.size() < max_length; ++c) {
    if (*c != '\n')
      text += *c;
    else if (!text.empty() && !text.ends_with("; "))
      text += "; ";
  }
  while (text.ends_with(' ') || text.ends_with(';')) text.pop_back();
  return text.empty() ? "it does not say why" : text;
}

static GLuint compile(const Gl &gl, const ShaderStage &stage, std::map<std::string, std::string> generated) {
  generated["device.glsl"] = "#define GROUP_SIZE " + std::to_string(gl.limits.group_size) + " // invocations per work group\n";
  const std::string source = shader_source(stage.path, generated);
  const char *text = source.c_str();
  const GLuint shader = gl.CreateShader(stage.type);
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled) return shader;
  std::string log(2000, '\0');
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()) - 1, nullptr, log.data());
  gl.DeleteShader(shader);
  throw Error(PDESC_ERROR_UNSUPPORTED, "The graphics driver did not compile " + stage.path +
                                           ", use another backend and please report it (files " + file_list(source) +
                                           "): " + one_line(log.c_str()));
}

GLuint ProgramCache::find(const std::string &name) {
  const auto found = programs_.find(name);
  if (found == programs_.end()) return 0;
  found->second.last_call = ++calls_;
  return found->second.id;
}

GLuint ProgramCache::get(const Gl &gl, const std::string &name, const std::vector<ShaderStage> &stages,
                         const std::map<std::string, std::string> &generated) {
  if (const GLuint kept = find(name)) return kept;
  std::vector<GLuint> shaders;
  try {
    for (const ShaderStage &stage : stages) shaders.push_back(compile(gl, stage, generated));
  } catch (...) {
    for (const GLuint shader : shaders) gl.DeleteShader(shader);
    throw;
  }
  const GLuint program = gl.CreateProgram();
  for (const GLuint shader : shaders) gl.AttachShader(program, shader);
  gl.LinkProgram(program);
  for (const GLuint shader : shaders) gl.DeleteShader(shader);
  GLint linked = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (!linked) {
    std::string log(2000, '\0');
    gl.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()) - 1, nullptr, log.data());
    gl.DeleteProgram(program);
    throw Error(PDESC_ERROR_UNSUPPORTED, "The graphics driver did not link " + stages.back().path +
                                             ", use another backend and please report it: " + one_line(log.c_str()));
  }
  if (programs_.size() >= max_programs_) {
    const auto oldest = std::ranges::min_element(programs_, {}, [](const auto &entry) { return entry.second.last_call; });
    gl.DeleteProgram(oldest->second.id);
    programs_.erase(oldest);
  }
  programs_[name] = {program, ++calls_};
  return program;
}

} // namespace paradesc
