// Descriptor files → one program that shares one sampling; centers → tiles → results.
#include "descriptor/evaluate.h"

#include "descriptor/registry.h"
#include "sample/pattern.h"

namespace paradesc {

// Each descriptor's file defines the same names; they are told apart by renaming them while its text is compiled.
std::string compose_descriptors(std::span<const int> asked) {
  std::string text, members, init, add, finish;
  for (size_t row = 0; row < asked.size(); ++row) {
    const std::string name = descriptors()[static_cast<size_t>(asked[row])].name;
    for (const char *word : {"State", "descriptor_init", "descriptor_add", "descriptor_finish"})
      text += std::string("#define ") + word + " " + word + "_" + name + "\n";
    text += "#include \"descriptors/" + name + ".glsl\"\n";
    for (const char *word : {"State", "descriptor_init", "descriptor_add", "descriptor_finish"})
      text += std::string("#undef ") + word + "\n";
    members += "  State_" + name + " " + name + ";\n";
    init += "  descriptor_init_" + name + "(states." + name + ");\n";
    add += "  descriptor_add_" + name + "(states." + name + ", center, neighbor);\n";
    finish += "  results[(ROW_DESCRIPTORS + " + std::to_string(row) + ") * total + index] = descriptor_finish_" + name + "(states." + name +
              ", center, support);\n";
  }
  // The results buffer is declared after this text, so the last step is a macro for main().
  std::string macro;
  for (const char c : finish) {
    if (c == '\n') macro += " \\";
    macro.push_back(c);
  }
  text += "struct States {\n" + members + "};\n";
  text += "void states_init(out States states) {\n" + init + "}\n";
  text += "void states_add(inout States states, Center center, Neighbor neighbor) {\n" + add + "}\n";
  text += "#define STATES_FINISH \\\n" + macro + "\n";
  return text;
}

void Evaluator::set_borders(const Gl &gl, const BorderGrid &grid) {
  border_ = Texture(gl, grid.size, grid.size, GL_RG32I);
  gl.TextureSubImage2D(border_.id(), 0, 0, 0, grid.size, grid.size, GL_RG_INTEGER, GL_INT, grid.cells.data());
  border_list_.upload(gl, GL_RG32I, grid.list.data(), grid.list.size() / 2);
  border_uv_.upload(gl, GL_RGBA32F, grid.border_uv.data(), grid.border_uv.size());
  check_gl(gl, "border upload");
}

void Evaluator::set_frame(const Gl &gl, const std::vector<vec4> &links, const std::vector<CenterData> &centers, int interior) {
  links_.upload(gl, GL_RGBA32F, links.data(), links.size());
  centers_.upload(gl, centers, GL_STREAM_DRAW);
  count_ = static_cast<int>(centers.size());
  interior_ = interior;
  check_gl(gl, "center upload");
}

void Evaluator::set_settings(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings) {
  const int side = (buffer.size() + settings.block_size - 1) / settings.block_size;
  blocks_ = Texture(gl, side, side, GL_R32F);
  gl.UseProgram(programs.get(gl, "blocks", {{GL_COMPUTE_SHADER, "blocks.comp.glsl"}}));
  buffer.bind();
  gl.BindImageTexture(0, blocks_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  gl.Uniform1i(0, buffer.size());
  gl.Uniform1i(8, settings.block_size);
  gl.DispatchCompute(static_cast<GLuint>((side + 7) / 8), static_cast<GLuint>((side + 7) / 8), 1);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);

  scouts_.upload(gl, golden_angle_pattern(SCOUTS, MAX_SCOUTS));
  const auto count = static_cast<size_t>(count_);
  windows_.upload(gl, nullptr, count * MAX_WINDOWS * sizeof(WindowData), GL_STREAM_COPY);
  searches_.upload(gl, nullptr, count * sizeof(vec4), GL_STREAM_COPY);
  active_.upload(gl, nullptr, sizeof(GLuint), GL_STREAM_READ);
  // NaN everywhere first: a center that a driver forgets must not look like a result.
  const std::vector<float> nothing((ROW_DESCRIPTORS + settings.descriptors.size()) * count, std::numeric_limits<float>::quiet_NaN());
  results_.upload(gl, nothing, GL_STREAM_READ);
  check_gl(gl, "settings upload");
}

// One invocation a center, with what both kernels know.
static void dispatch(const Gl &gl, const EvaluateSettings &settings, int first, int last, int buffer_size) {
  gl.Uniform1i(0, buffer_size);
  gl.Uniform1i(2, first);
  gl.Uniform1i(3, last);
  gl.Uniform1f(6, settings.radius);
  gl.Uniform1f(7, settings.enlargement);
  gl.DispatchCompute(static_cast<GLuint>((last - first + GROUP_SIZE - 1) / GROUP_SIZE), 1, 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void Evaluator::find_windows(const Gl &gl, ProgramCache &programs, const EvaluateSettings &settings, int first, int last,
                             int buffer_size) const {
  gl.UseProgram(programs.get(gl, "windows", {{GL_COMPUTE_SHADER, "windows.comp.glsl"}}));
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PATTERN, scouts_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_ACTIVE, active_.id());
  gl.Uniform1i(1, settings.max_jumps);
  gl.Uniform1i(10, interior_);
  const int rounds = last <= interior_ ? 1 : MAX_WINDOWS;
  for (int round = 0; round < rounds; ++round) {
    bool more = false;
    for (int begin = 0; begin < MAX_SCOUTS; begin += SCOUT_PARTY) {
      GLuint active = 0;
      gl.NamedBufferSubData(active_.id(), 0, sizeof active, &active);
      gl.Uniform1i(8, round);
      gl.Uniform1i(9, begin);
      dispatch(gl, settings, first, last, buffer_size);
      gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      gl.GetNamedBufferSubData(active_.id(), 0, sizeof active, &active);
      more |= active > 0;
      if (active == 0) break;
    }
    if (!more) break;
  }
  gl.UseProgram(programs.get(gl, "grow", {{GL_COMPUTE_SHADER, "grow.comp.glsl"}}));
  dispatch(gl, settings, first, last, buffer_size);
}

void Evaluator::run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings, int first,
                    int last) const {
  buffer.bind();
  gl.BindTextureUnit(UNIT_BORDER, border_.id());
  gl.BindTextureUnit(UNIT_BORDER_LIST, border_list_.id());
  gl.BindTextureUnit(UNIT_BORDER_UV, border_uv_.id());
  gl.BindTextureUnit(UNIT_LINKS, links_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, centers_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_WINDOWS, windows_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SEARCH, searches_.id());
  find_windows(gl, programs, settings, first, last, buffer.size());

  std::string name = "evaluate";
  for (const int descriptor : settings.descriptors) name += " " + std::to_string(descriptor);
  gl.UseProgram(programs.get(gl, name, {{GL_COMPUTE_SHADER, "evaluate.comp.glsl"}},
                             {{"descriptors.glsl", compose_descriptors(settings.descriptors)}}));
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULTS, results_.id());
  gl.Uniform1i(4, count_);
  gl.Uniform1i(5, settings.samples);
  gl.Uniform1i(8, settings.block_size);
  gl.Uniform1i(9, static_cast<GLint>(settings.seed));
  gl.BindTextureUnit(UNIT_BLOCKS, blocks_.id());
  dispatch(gl, settings, first, last, buffer.size());
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.Finish();
  check_gl(gl, "evaluate");
}

std::vector<float> Evaluator::read(const Gl &gl, const EvaluateSettings &settings) const {
  std::vector<float> results((ROW_DESCRIPTORS + settings.descriptors.size()) * static_cast<size_t>(count_));
  if (!results.empty())
    gl.GetNamedBufferSubData(results_.id(), 0, static_cast<GLsizeiptr>(results.size() * sizeof(float)), results.data());
  check_gl(gl, "read-back");
  return results;
}

} // namespace paradesc
