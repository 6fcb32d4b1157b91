// Descriptor files → one program that shares one sampling; centers → tiles → results.
#include "descriptor/evaluate.h"

#include "descriptor/registry.h"
#include "sample/pattern.h"

namespace paradesc {

size_t EvaluateSettings::value_rows() const {
  size_t rows = 0;
  for (const int descriptor : this->descriptors) rows += static_cast<size_t>(descriptor_row(descriptor).components);
  return rows;
}

// Each descriptor's file defines the same names; they are told apart by renaming them while its text is compiled.
std::string compose_descriptors(std::span<const int> asked) {
  std::string text, members, init, add, finish;
  int row = 0;
  for (const int descriptor : asked) {
    const DescriptorRow &registered = descriptor_row(descriptor);
    const std::string name = registered.name;
    for (const char *word : {"State", "descriptor_init", "descriptor_add", "descriptor_finish"})
      text += std::string("#define ") + word + " " + word + "_" + name + "\n";
    text += std::string("#include \"") + (registered.map_degree ? "operators/" : "descriptors/") + name + ".glsl\"\n";
    for (const char *word : {"State", "descriptor_init", "descriptor_add", "descriptor_finish"})
      text += std::string("#undef ") + word + "\n";
    members += "  State_" + name + " " + name + ";\n";
    init += "  descriptor_init_" + name + "(states." + name + ");\n";
    add += "  descriptor_add_" + name + "(states." + name + ", center, neighbor);\n";
    const std::string value = "descriptor_finish_" + name + "(states." + name + ", center, support)";
    auto store = [&](const std::string &component) {
      finish += "  results[(ROW_DESCRIPTORS + " + std::to_string(row++) + ") * total + index] = " + component + ";\n";
    };
    if (registered.components == 1) {
      store(value);
      continue;
    }
    finish += "  vec3 value_" + name + " = " + value + ";\n";
    for (const char *axis : {".x", ".y", ".z"}) store("value_" + name + axis);
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

void Evaluator::set_cells(const Gl &gl, const Cells &cells, int buffer_size) {
  labels_ = Texture(gl, buffer_size, buffer_size, GL_RG32I);
  gl.TextureSubImage2D(labels_.id(), 0, 0, 0, buffer_size, buffer_size, GL_RG_INTEGER, GL_INT, cells.label.data());
  corners_.upload(gl, GL_RG32I, cells.corner.data(), cells.corner.size() / 2);
  cell_count_ = cells.count;
  block_size_ = cells.block_size;
  check_gl(gl, "cell upload");
}

void Evaluator::bind(const Gl &gl, const GeometryBuffer &buffer) const {
  buffer.bind();
  gl.BindTextureUnit(UNIT_LABELS, labels_.id());
  gl.BindTextureUnit(UNIT_CORNERS, corners_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_AREAS, areas_.id());
  gl.Uniform1i(0, buffer.size());
  gl.Uniform1i(8, block_size_);
}

void Evaluator::measure_cells(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer) {
  areas_.upload(gl, nullptr, static_cast<size_t>(cell_count_) * sizeof(float), GL_STREAM_COPY);
  if (cell_count_ == 0) return;
  gl.UseProgram(programs.get(gl, "cells", {{GL_COMPUTE_SHADER, "cells.comp.glsl"}}));
  bind(gl, buffer);
  gl.Uniform1i(3, cell_count_);
  gl.DispatchCompute(static_cast<GLuint>((cell_count_ + GROUP_SIZE - 1) / GROUP_SIZE), 1, 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  check_gl(gl, "cells");
}

void Evaluator::set_links(const Gl &gl, const std::vector<vec4> &links) {
  links_.upload(gl, GL_RGBA32F, links.data(), links.size());
}

void Evaluator::set_supports(const Gl &gl, const Supports &supports, const BareSamples &bare) {
  bare_begin_.upload(gl, bare.begin, GL_STREAM_DRAW);
  bare_.upload(gl, bare.point, GL_STREAM_DRAW);
  std::vector<SupportData> data;
  data.reserve(supports.range.size());
  for (size_t i = 0; i < supports.range.size(); ++i)
    data.push_back({supports.range[i].x, supports.range[i].y, supports.boundary[i] ? 1.0f : 0.0f, 0.0f});
  supports_.upload(gl, data, GL_STREAM_DRAW);
  support_cells_.upload(gl, supports.cell, GL_STREAM_DRAW);
  check_gl(gl, "support upload");
}

void Evaluator::set_map(const Gl &gl, const std::vector<vec4> &centers, const std::vector<vec4> &bare) {
  map_centers_.upload(gl, centers, GL_STREAM_DRAW);
  map_bare_.upload(gl, bare, GL_STREAM_DRAW);
  check_gl(gl, "map upload");
}

void Evaluator::set_centers(const Gl &gl, const std::vector<CenterData> &centers, const EvaluateSettings &settings) {
  centers_.upload(gl, centers, GL_STREAM_DRAW);
  count_ = static_cast<int>(centers.size());
  pattern_.upload(gl, golden_angle_pattern(settings.samples));
  // NaN everywhere first: a center that a driver forgets must not look like a result.
  const std::vector<float> nothing((ROW_DESCRIPTORS + settings.value_rows()) * static_cast<size_t>(count_),
                                   std::numeric_limits<float>::quiet_NaN());
  results_.upload(gl, nothing, GL_STREAM_READ);
  check_gl(gl, "center upload");
}

// What is decided while compiling: each choice costs nothing where it is not made.
static std::string variant_of(const EvaluateSettings &settings) {
  auto define = [](const char *name, bool value) { return std::string("#define ") + name + (value ? " 1\n" : " 0\n"); };
  return define("AFFINE", settings.relocation == PDESC_RELOCATION_AFFINE) + define("INTEGRAL", settings.integral) +
         define("GEODESIC_BALL", settings.geodesic_ball) + define("MAP", settings.map != nullptr) +
         define("ADAPTIVE", settings.adaptive > 0.0f);
}

void Evaluator::run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings,
                    int first, int last) const {
  const std::string variant = variant_of(settings);
  std::string name = "evaluate " + variant;
  for (const int descriptor : settings.descriptors) name += " " + std::to_string(descriptor);
  gl.UseProgram(programs.get(gl, name, {{GL_COMPUTE_SHADER, "evaluate.comp.glsl"}},
                             {{"variant.glsl", variant}, {"descriptors.glsl", compose_descriptors(settings.descriptors)}}));
  bind(gl, buffer);
  gl.BindTextureUnit(UNIT_BORDER, border_.id());
  gl.BindTextureUnit(UNIT_BORDER_LIST, border_list_.id());
  gl.BindTextureUnit(UNIT_BORDER_UV, border_uv_.id());
  gl.BindTextureUnit(UNIT_LINKS, links_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, centers_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PATTERN, pattern_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULTS, results_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SUPPORTS, supports_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CELLS, support_cells_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_BARE_BEGIN, bare_begin_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_BARE, bare_.id());
  if (settings.relocation != PDESC_RELOCATION_CONNECTED) gl.Uniform1i(1, settings.max_jumps);
  const GLint integers[] = {first, last, count_, settings.samples};
  for (GLint i = 0; i < 4; ++i) gl.Uniform1i(i + 2, integers[i]);
  gl.Uniform1f(6, settings.radius);
  gl.Uniform1f(7, settings.enlargement);
  gl.Uniform1i(9, static_cast<GLint>(settings.seed));
  gl.Uniform1f(10, settings.plain ? 0.0f : 1.0f);
  if (settings.adaptive > 0.0f) gl.Uniform1f(11, settings.adaptive);
  if (settings.map) {
    settings.map->bind();
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MAP_CENTERS, map_centers_.id());
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MAP_BARE, map_bare_.id());
    gl.Uniform1f(12, settings.map_sigma);
    gl.Uniform1f(13, settings.harris_k);
    gl.Uniform1f(14, settings.map_radius);
  }
  gl.DispatchCompute(static_cast<GLuint>((last - first + GROUP_SIZE - 1) / GROUP_SIZE), 1, 1);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.Finish();
  check_gl(gl, "evaluate");
}

std::vector<float> Evaluator::read(const Gl &gl, const EvaluateSettings &settings) const {
  std::vector<float> results((ROW_DESCRIPTORS + settings.value_rows()) * static_cast<size_t>(count_));
  if (!results.empty())
    gl.GetNamedBufferSubData(results_.id(), 0, static_cast<GLsizeiptr>(results.size() * sizeof(float)), results.data());
  check_gl(gl, "read-back");
  return results;
}

} // namespace paradesc
