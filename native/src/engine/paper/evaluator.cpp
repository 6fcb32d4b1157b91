// Descriptor files → one program that shares one sampling; centers → tiles → results.
#include "engine/paper/evaluator.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "descriptor/registry.h"
#include "engine/paper/compose.h"
#include "engine/paper/pattern.h"

namespace paradesc {

size_t EvaluateSettings::value_rows() const {
  size_t rows = 0;
  for (const int descriptor : this->descriptors) rows += static_cast<size_t>(descriptor_row(descriptor).components);
  return rows;
}

bool EvaluateSettings::faces() const {
  const bool measures_area = std::ranges::any_of(descriptors, [](int row) { return uses_terms(row, "area"); });
  return !displaced && (estimator == PDESC_ESTIMATOR_INTEGRAL || measures_area);
}

void Evaluator::set_borders(const Gl &gl, const BorderGrid &grid) {
  border_ = Texture(gl, grid.size, grid.size, GL_RG32I);
  gl.TextureSubImage2D(border_.id(), 0, 0, 0, grid.size, grid.size, GL_RG_INTEGER, GL_INT, grid.cells.data());
  border_list_.upload(gl, GL_RG32I, grid.list, GL_STATIC_DRAW);
  border_uv_.upload(gl, GL_RGBA32F, grid.border_uv, GL_STATIC_DRAW);
  check_gl(gl, "border upload");
}

void Evaluator::set_links(const Gl &gl, const std::vector<vec4> &links, const std::vector<int32_t> &seams) {
  links_.upload(gl, GL_RGBA32F, links, GL_STREAM_DRAW);
  seams_.upload(gl, seams);
}

void Evaluator::set_faces(const Gl &gl, const Triangles &triangles) {
  std::vector<vec4> faces;
  faces.reserve(static_cast<size_t>(triangles.triangle_count));
  for (int32_t t = 0; t < triangles.triangle_count; ++t) {
    const dvec3 a(triangles.position(3 * t)), b(triangles.position(3 * t + 1)), c(triangles.position(3 * t + 2));
    const dvec3 product = cross(b - a, c - a);
    const double size = length(product);
    faces.emplace_back(size > 0.0 ? vec3(product / size) : vec3(0.0f), 0.0f);
  }
  faces_.upload(gl, GL_RGBA32F, faces, GL_STREAM_DRAW);
}

void Evaluator::set_map(const Gl &gl, const std::vector<vec4> &centers) {
  map_centers_.upload(gl, centers, GL_STREAM_DRAW);
  check_gl(gl, "map upload");
}

void Evaluator::set_centers(const Gl &gl, const std::vector<CenterData> &centers) {
  centers_.upload(gl, centers, GL_STREAM_DRAW);
  count_ = static_cast<int>(centers.size());
  check_gl(gl, "center upload");
}

static size_t result_values(const EvaluateSettings &settings, int count) {
  return (ROW_DESCRIPTORS + settings.value_rows()) * static_cast<size_t>(count);
}

// The largest number of centers in one dispatch, in whole groups.
size_t Evaluator::centers_side_by_side(const Gl &gl, const EvaluateSettings &settings) const {
  return std::min(in_whole_groups(gl, static_cast<size_t>(count_)), static_cast<size_t>(settings.most_centers()));
}

void Evaluator::begin(const Gl &gl, const EvaluateSettings &settings) {
  pattern_.upload(gl, settings.pattern == PDESC_PATTERN_STRATIFIED ? stratified_pattern(settings.samples, settings.seed)
                                                                   : golden_angle_pattern(settings.samples));
  const bool directional = settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL;
  visits_.reserve(gl, settings.paper ? centers_side_by_side(gl, settings) * MAX_VISITS * sizeof(VisitData) : 0);
  stretches_.reserve(gl, directional ? static_cast<size_t>(count_) * STRETCH_DIRECTIONS * sizeof(float) : 0);
  // Starts with NaN everywhere: a center that a driver skips must not look like a result.
  results_.repeat(gl, std::bit_cast<uint32_t>(std::numeric_limits<float>::quiet_NaN()), result_values(settings, count_),
                  GL_STREAM_READ);
  check_gl(gl, "room for results");
}

// These choices are made at compile time, so that untaken branches cost nothing.
static std::string variant_of(const EvaluateSettings &settings, const char *buffer_variant) {
  return define("PAPER", settings.paper) + define("DIRECTIONAL", settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL) +
         define("CHORDS", settings.chords) + define("INTEGRAL", settings.estimator == PDESC_ESTIMATOR_INTEGRAL) +
         define("EXTRAPOLATED", settings.estimator == PDESC_ESTIMATOR_EXTRAPOLATED) +
         define("GEODESIC_BALL", settings.geodesic_ball) + define("ADAPTIVE", settings.adaptive > 0.0f) +
         define("MAP", settings.map) + define("FACES", settings.faces()) + buffer_variant;
}

GLuint evaluate_program(const Gl &gl, ProgramCache &programs, const EvaluateSettings &settings, const char *buffer_variant) {
  const std::string variant = variant_of(settings, buffer_variant);
  std::string name = "evaluate " + variant;
  for (const int descriptor : settings.descriptors) name += " " + std::to_string(descriptor);
  if (const GLuint kept = programs.find(name)) return kept; // skips composing the program's long text
  const bool integral = settings.estimator == PDESC_ESTIMATOR_INTEGRAL;
  return programs.get(gl, name, {{GL_COMPUTE_SHADER, "paper/evaluate/evaluate.comp.glsl"}},
                      {{"variant.glsl", variant},
                       {"terms.glsl", compose_terms(settings.descriptors, integral)},
                       {"descriptors.glsl", compose_descriptors(settings.descriptors)}});
}

// Binds the inputs of samples that march.
void Evaluator::bind_march(const Gl &gl) const {
  gl.BindTextureUnit(UNIT_BORDER, border_.id());
  gl.BindTextureUnit(UNIT_BORDER_LIST, border_list_.id());
  gl.BindTextureUnit(UNIT_BORDER_UV, border_uv_.id());
  gl.BindTextureUnit(UNIT_LINKS, links_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, centers_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PATTERN, pattern_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_VISITS, visits_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SEAMS, seams_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_STRETCHES, stretches_.id());
}

void Evaluator::find_stretches(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer,
                               const EvaluateParams &params) const {
  gl.UseProgram(programs.get(gl, "stretch", {{GL_COMPUTE_SHADER, "paper/march/stretch.comp.glsl"}},
                             {{"variant.glsl", define("PAPER", 0)}}));
  buffer.bind();
  buffer.bind_owners();
  gl.Uniform1i(LOCATION_BUFFER_SIZE, buffer.size());
  bind_march(gl);
  gl.DispatchCompute(group_count(gl, (params.last - params.first) * STRETCH_DIRECTIONS), 1, 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  check_gl(gl, "stretches");
}

// Samples that march are spread over several dispatches, each of which passes its sums on to the next: software devices limit
// the iterations of one dispatch.
void Evaluator::dispatch_marches(const Gl &gl, GLuint program, const EvaluateSettings &settings, EvaluateParams params) {
  const GLuint block = gl.GetProgramResourceIndex(program, GL_SHADER_STORAGE_BLOCK, "Progresses");
  const GLenum property = GL_BUFFER_DATA_SIZE; // for one element
  GLint stride = 0;
  gl.GetProgramResourceiv(program, GL_SHADER_STORAGE_BLOCK, block, 1, &property, 1, nullptr, &stride);
  const GLuint groups = group_count(gl, params.last - params.first);
  progress_.reserve(gl, centers_side_by_side(gl, settings) * static_cast<size_t>(stride));
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PROGRESS, progress_.id());
  const bool adaptive = settings.adaptive > 0.0f;
  for (int marks = settings.paper ? 1 : 0; marks >= 0; --marks) {
    for (int begin = 0, end = 0; begin < settings.samples; begin = end) {
      end = std::min(begin + settings.samples_at_once, settings.samples);
      const int half = (settings.samples + 1) / 2;
      if (adaptive && begin < half) end = std::min(end, half);
      params.begin_sample = begin;
      params.end_sample = end;
      params.marks_only = marks;
      params_.fill(gl, &params, sizeof params, GL_STREAM_DRAW);
      gl.DispatchCompute(groups, 1, 1);
      gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
  }
}

EvaluateParams Evaluator::params_of(const EvaluateSettings &settings, int first, int last) const {
  return {.first = first,
          .last = last,
          .total = count_,
          .samples = settings.samples,
          .radius = settings.radius,
          .variate_share = settings.use_control_variate ? 1.0f : 0.0f,
          .adaptive = settings.adaptive,
          .map_radius = settings.map_radius,
          .map_sigma = settings.map_sigma,
          .harris_k = settings.harris_k,
          .enlargement = settings.enlargement,
          .max_jumps = settings.max_jumps,
          .begin_sample = 0,
          .end_sample = settings.samples,
          .marks_only = 0,
          .unused = 0};
}

// Binds the inputs of one program.
void Evaluator::bind(const Gl &gl, const GeometryBuffer &buffer, const EvaluateSettings &settings) const {
  buffer.bind();
  bind_march(gl);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULTS, results_.id());
  if (settings.map) {
    buffer.bind_map();
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MAP_CENTERS, map_centers_.id());
  }
  if (settings.faces()) gl.BindTextureUnit(UNIT_FACES, faces_.id());
}

void Evaluator::run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings,
                    int first, int last) {
  for (int end = first; first < last; first = end) {
    end = std::min(first + settings.most_centers(), last);
    const EvaluateParams params = params_of(settings, first, end);
    params_.fill(gl, &params, sizeof params, GL_STREAM_DRAW);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_EVALUATE, params_.id());
    if (settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL) find_stretches(gl, programs, buffer, params);
    bind(gl, buffer, settings);
    const GLuint program = evaluate_program(gl, programs, settings, buffer.variant());
    gl.UseProgram(program);
    gl.Uniform1i(LOCATION_BUFFER_SIZE, buffer.size());
    gl.Uniform1f(LOCATION_AREA_UNIT, buffer.area_unit());
    dispatch_marches(gl, program, settings, params);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    if (end < last) gl.Flush();
  }
  gl.Finish();
  check_gl(gl, "evaluate");
}

void Evaluator::read(const Gl &gl, const EvaluateSettings &settings, std::vector<float> &rows) const {
  rows.resize(result_values(settings, count_));
  gl.GetNamedBufferSubData(results_.id(), 0, static_cast<GLsizeiptr>(rows.size() * sizeof(float)), rows.data());
  check_gl(gl, "read-back");
}

} // namespace paradesc
