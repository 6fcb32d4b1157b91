// Descriptor files → one program that shares one sampling; centers → tiles → results.
#include "engine/opengl/evaluator.h"

#include <algorithm>
#include <string_view>

#include "descriptor/registry.h"
#include "sample/pattern.h"

namespace paradesc {

size_t EvaluateSettings::value_rows() const {
  size_t rows = 0;
  for (const int descriptor : this->descriptors) rows += static_cast<size_t>(descriptor_row(descriptor).components);
  return rows;
}

// Descriptors of areas share the sums of kernel/terms/area.glsl.
bool EvaluateSettings::faces() const {
  auto measures_area = [](int descriptor) {
    const std::string file = std::string("kernel/descriptors/") + descriptor_row(descriptor).name + ".glsl";
    return std::ranges::any_of(embedded_shaders(), [&](const EmbeddedShader &shader) {
      return shader.path == file && std::string_view(shader.text).find("\"kernel/terms/area.glsl\"") != std::string_view::npos;
    });
  };
  return !mapped && (estimator != PDESC_ESTIMATOR_SHAPE_OPERATOR || std::ranges::any_of(descriptors, measures_area));
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
    text +=
        std::string("#include \"") + (registered.map_degree ? "kernel/operators/" : "kernel/descriptors/") + name + ".glsl\"\n";
    for (const char *word : {"State", "descriptor_init", "descriptor_add", "descriptor_finish"})
      text += std::string("#undef ") + word + "\n";
    members += "  State_" + name + " " + name + ";\n";
    init += "  descriptor_init_" + name + "(states." + name + ");\n";
    add += "  descriptor_add_" + name + "(states." + name + ", center, neighbor);\n";
    const std::string value = "descriptor_finish_" + name + "(states." + name + ", center, support)";
    auto store = [&](const std::string &component) {
      finish +=
          "  results[(ROW_DESCRIPTORS + " + std::to_string(row++) + ") * total + index] = floatBitsToUint(" + component + ");\n";
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

void Evaluator::set_links(const Gl &gl, const std::vector<vec4> &links, const std::vector<int32_t> &seams) {
  links_.upload(gl, GL_RGBA32F, links.data(), links.size());
  seams_.upload(gl, seams);
}

void Evaluator::set_supports(const Gl &gl, const Supports &supports, const BareSamples &bare) {
  bare_.upload(gl, bare.point, GL_STREAM_DRAW);
  has_bare_ = !bare.point.empty();
  supports_.upload(gl, supports.center, GL_STREAM_DRAW);
  ranges_.upload(gl, supports.range, GL_STREAM_DRAW);
  check_gl(gl, "support upload");
}

void Evaluator::set_faces(const Gl &gl, const std::vector<vec4> &normals) {
  faces_.upload(gl, GL_RGBA32F, normals.data(), normals.size());
  check_gl(gl, "face upload");
}

void Evaluator::set_reach(const Gl &gl, std::span<const int32_t> centers, const Reach &reach) {
  std::vector<int32_t> all(centers.begin(), centers.end());
  reach_count_ = static_cast<int>(all.size());
  const auto offset = static_cast<int32_t>(centers.size() + reach.begin.size());
  for (const int32_t begin : reach.begin) all.push_back(begin + offset);
  all.insert(all.end(), reach.triangle.begin(), reach.triangle.end());
  reach_.upload(gl, all, GL_STREAM_DRAW);
  check_gl(gl, "reach upload");
}

void Evaluator::set_map(const Gl &gl, const std::vector<vec4> &centers, const std::vector<vec4> &bare) {
  map_centers_.upload(gl, centers, GL_STREAM_DRAW);
  map_bare_.upload(gl, bare, GL_STREAM_DRAW);
  check_gl(gl, "map upload");
}

void Evaluator::set_centers(const Gl &gl, const std::vector<CenterData> &centers, const EvaluateSettings &settings) {
  centers_.upload(gl, centers, GL_STREAM_DRAW);
  count_ = static_cast<int>(centers.size());
  pattern_.upload(gl, settings.pattern == PDESC_PATTERN_STRATIFIED ? stratified_pattern(settings.samples, settings.seed)
                                                                   : golden_angle_pattern(settings.samples));
  const auto tile =
      static_cast<size_t>(std::min(static_cast<int>(group_count(gl, count_)) * gl.limits.group_size, settings.largest_tile()));
  const bool paper = settings.relocation == PDESC_RELOCATION_PAPER, directional = settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL;
  visits_.upload(gl, nullptr, paper ? tile * MAX_VISITS * sizeof(VisitData) : 0, GL_STREAM_COPY);
  stretches_.upload(gl, nullptr, directional ? static_cast<size_t>(count_) * STRETCH_DIRECTIONS * sizeof(float) : 0,
                    GL_STREAM_COPY);
  // NaN everywhere first: a center that a driver forgets must not look like a result.
  const std::vector<float> nothing((ROW_DESCRIPTORS + settings.value_rows()) * static_cast<size_t>(count_),
                                   std::numeric_limits<float>::quiet_NaN());
  results_.upload(gl, nothing, GL_STREAM_READ);
  check_gl(gl, "center upload");
}

// What is decided while compiling: each choice costs nothing where it is not made.
static std::string variant_of(const EvaluateSettings &settings, const GeometryBuffer &buffer, bool bare, bool listed) {
  auto define = [](const char *name, bool value) { return std::string("#define ") + name + (value ? " 1\n" : " 0\n"); };
  return define("AFFINE", settings.relocation == PDESC_RELOCATION_AFFINE) +
         define("PAPER", settings.relocation == PDESC_RELOCATION_PAPER) +
         define("DIRECTIONAL", settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL) + define("CHORDS", settings.chords) +
         define("INTEGRAL", settings.estimator != PDESC_ESTIMATOR_SHAPE_OPERATOR) +
         define("EXTRAPOLATED", settings.estimator == PDESC_ESTIMATOR_EXTRAPOLATED) +
         define("GEODESIC_BALL", settings.geodesic_ball) + define("ADAPTIVE", settings.adaptive > 0.0f) +
         define("EXACT", settings.exact) + define("MAP", settings.map != nullptr) + define("FACES", settings.faces()) +
         define("BARE", bare) + define("LISTED", listed) + buffer.variant();
}

// What samples read that are carried over seams by walks.
void Evaluator::bind_walks(const Gl &gl, const EvaluateSettings &settings, int first, int last) const {
  gl.BindTextureUnit(UNIT_BORDER, border_.id());
  gl.BindTextureUnit(UNIT_BORDER_LIST, border_list_.id());
  gl.BindTextureUnit(UNIT_BORDER_UV, border_uv_.id());
  gl.BindTextureUnit(UNIT_LINKS, links_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, centers_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PATTERN, pattern_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_VISITS, visits_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SEAMS, seams_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_STRETCHES, stretches_.id());
  gl.Uniform1i(1, settings.max_jumps);
  gl.Uniform1i(2, first);
  gl.Uniform1i(3, last);
  gl.Uniform1f(6, settings.radius);
  gl.Uniform1f(7, settings.enlargement);
}

void Evaluator::find_stretches(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer,
                               const EvaluateSettings &settings, int first, int last) const {
  gl.UseProgram(programs.get(gl, "stretch", {{GL_COMPUTE_SHADER, "opengl/march/stretch.comp.glsl"}},
                             {{"variant.glsl", "#define PAPER 0\n"}}));
  buffer.bind();
  buffer.bind_owners();
  gl.Uniform1i(0, buffer.size());
  bind_walks(gl, settings, first, last);
  gl.DispatchCompute(group_count(gl, (last - first) * STRETCH_DIRECTIONS), 1, 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  check_gl(gl, "stretches");
}

// Samples that walk take their turns in several dispatches, and leave their sums to the next: software devices limit the
// iterations of one.
void Evaluator::dispatch_walks(const Gl &gl, GLuint program, const EvaluateSettings &settings, int count) {
  const GLuint block = gl.GetProgramResourceIndex(program, GL_SHADER_STORAGE_BLOCK, "Progresses");
  const GLenum property = GL_BUFFER_DATA_SIZE; // with one element
  GLint stride = 0;
  gl.GetProgramResourceiv(program, GL_SHADER_STORAGE_BLOCK, block, 1, &property, 1, nullptr, &stride);
  const auto groups = group_count(gl, count);
  const size_t bytes = static_cast<size_t>(groups) * static_cast<size_t>(gl.limits.group_size) * static_cast<size_t>(stride);
  if (bytes > progress_bytes_) progress_.upload(gl, nullptr, progress_bytes_ = bytes, GL_STREAM_COPY);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PROGRESS, progress_.id());
  const bool adaptive = settings.adaptive > 0.0f;
  for (int marks = settings.relocation == PDESC_RELOCATION_PAPER ? 1 : 0; marks >= 0; --marks) {
    gl.Uniform1i(22, marks);
    for (int begin = 0, end = 0; begin < settings.samples; begin = end) {
      end = std::min(begin + settings.samples_at_once, settings.samples);
      const int half = (settings.samples + 1) / 2;
      if (adaptive && begin < half) end = std::min(end, half);
      gl.Uniform1i(20, begin);
      gl.Uniform1i(21, end);
      gl.DispatchCompute(groups, 1, 1);
      gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
  }
}

void Evaluator::run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings,
                    int first, int last) {
  const bool walks = settings.relocation != PDESC_RELOCATION_CONNECTED;
  if (walks && settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL) find_stretches(gl, programs, buffer, settings, first, last);
  const std::string variant = variant_of(settings, buffer, has_bare_, !walks && settings.cells->listed());
  std::string name = "evaluate " + variant;
  for (const int descriptor : settings.descriptors) name += " " + std::to_string(descriptor);
  const GLuint program =
      programs.get(gl, name, {{GL_COMPUTE_SHADER, "opengl/evaluate/evaluate.comp.glsl"}},
                   {{"variant.glsl", variant}, {"descriptors.glsl", compose_descriptors(settings.descriptors)}});
  gl.UseProgram(program);
  buffer.bind();
  gl.Uniform1i(0, buffer.size());
  gl.Uniform1f(LOCATION_AREA_UNIT, buffer.area_unit());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, centers_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULTS, results_.id());
  if (walks) {
    bind_walks(gl, settings, first, last);
  } else {
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SUPPORTS, supports_.id());
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_BARE, bare_.id());
    gl.BindTextureUnit(UNIT_RANGES, ranges_.id());
    settings.cells->bind(gl);
  }
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
  if (settings.faces()) gl.BindTextureUnit(UNIT_FACES, faces_.id());
  if (settings.exact) {
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_REACH, reach_.id());
    gl.Uniform1i(15, reach_count_);
  }
  if (walks)
    dispatch_walks(gl, program, settings, last - first);
  else
    gl.DispatchCompute(group_count(gl, last - first), 1, 1);
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
