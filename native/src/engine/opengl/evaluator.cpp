// Descriptor files → one program that shares one sampling; centers → tiles → results.
#include "engine/opengl/evaluator.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "descriptor/registry.h"
#include "engine/opengl/compose.h"
#include "sample/centers.h"
#include "sample/pattern.h"

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
  border_list_.upload(gl, GL_RG32I, grid.list.data(), grid.list.size() / 2);
  border_uv_.upload(gl, GL_RGBA32F, grid.border_uv.data(), grid.border_uv.size());
  check_gl(gl, "border upload");
}

void Evaluator::set_links(const Gl &gl, const std::vector<vec4> &links, const std::vector<int32_t> &seams) {
  links_.upload(gl, GL_RGBA32F, links.data(), links.size());
  seams_.upload(gl, seams);
}

void Evaluator::set_map(const Gl &gl, const std::vector<vec4> &centers, const std::vector<vec4> &texelless) {
  map_centers_.upload(gl, centers, GL_STREAM_DRAW);
  map_texelless_.upload(gl, texelless, GL_STREAM_DRAW);
  check_gl(gl, "map upload");
}

void Evaluator::set_centers(const Gl &gl, const std::vector<CenterData> &centers) {
  centers_.upload(gl, centers, GL_STREAM_DRAW);
  use_centers(centers_.id(), static_cast<int>(centers.size()));
  check_gl(gl, "center upload");
}

void Evaluator::use_centers(GLuint centers, int count) {
  used_centers_ = centers;
  count_ = count;
}

// Numbers that follow the results: SearchCounts, then the counts of ConnectedTriangles.
static constexpr size_t counts_read = sizeof(SearchCounts) / sizeof(float) + 2;
static_assert(CONNECTED_PATCHES == CONNECTED_AMBIGUOUS + 1);

// The length of the results proper.
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
  const bool paper = settings.relocation == PDESC_RELOCATION_PAPER, directional = settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL;
  visits_.reserve(gl, paper ? centers_side_by_side(gl, settings) * MAX_VISITS * sizeof(VisitData) : 0);
  stretches_.reserve(gl, directional ? static_cast<size_t>(count_) * STRETCH_DIRECTIONS * sizeof(float) : 0);
  // Starts with NaN everywhere: a center that a driver skips must not look like a result.
  results_.repeat(gl, std::bit_cast<uint32_t>(std::numeric_limits<float>::quiet_NaN()),
                  result_values(settings, count_) + counts_read, GL_STREAM_READ);
  if (settings.connected) settings.connected->begin(gl, count_, settings.most_centers());
  check_gl(gl, "room for results");
}

// These choices are made at compile time, so that untaken branches cost nothing.
static std::string variant_of(const EvaluateSettings &settings, const char *buffer_variant, bool texelless) {
  return define("AFFINE", settings.relocation == PDESC_RELOCATION_AFFINE) +
         define("PAPER", settings.relocation == PDESC_RELOCATION_PAPER) +
         define("DIRECTIONAL", settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL) + define("CHORDS", settings.chords) +
         define("INTEGRAL", settings.estimator == PDESC_ESTIMATOR_INTEGRAL) +
         define("EXTRAPOLATED", settings.estimator == PDESC_ESTIMATOR_EXTRAPOLATED) +
         define("GEODESIC_BALL", settings.geodesic_ball) + define("ADAPTIVE", settings.adaptive > 0.0f) +
         define("EXACT", settings.exact) + define("MAP", settings.map != nullptr) + define("FACES", settings.faces()) +
         define("TEXELLESS", texelless) + define("LISTED", settings.points != nullptr) + buffer_variant;
}

GLuint evaluate_program(const Gl &gl, ProgramCache &programs, const EvaluateSettings &settings, const char *buffer_variant,
                        bool texelless) {
  const std::string variant = variant_of(settings, buffer_variant, texelless);
  std::string name = "evaluate " + variant;
  for (const int descriptor : settings.descriptors) name += " " + std::to_string(descriptor);
  if (const GLuint kept = programs.find(name)) return kept; // skips composing the program's long text
  const bool integral = settings.estimator == PDESC_ESTIMATOR_INTEGRAL;
  return programs.get(gl, name, {{GL_COMPUTE_SHADER, "opengl/evaluate/evaluate.comp.glsl"}},
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
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, used_centers_);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PATTERN, pattern_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_VISITS, visits_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_SEAMS, seams_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_STRETCHES, stretches_.id());
}

void Evaluator::find_stretches(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer,
                               const EvaluateParams &params) const {
  gl.UseProgram(programs.get(gl, "stretch", {{GL_COMPUTE_SHADER, "opengl/march/stretch.comp.glsl"}},
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
  for (int marks = settings.relocation == PDESC_RELOCATION_PAPER ? 1 : 0; marks >= 0; --marks) {
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

// The tolerance of areas, in squared radii: samples of a folded surface miss some per cent of a disk, and few samples miss more.
static float area_tolerance(int samples) {
  const double within = samples / static_cast<double>(ellipse_enlargement * ellipse_enlargement);
  return static_cast<float>(pi * std::max(0.06, 1.1 * std::pow(within, -0.75)));
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
          .slots = settings.connected ? settings.connected->slots() : 0,
          .flood_table = settings.connected ? settings.connected->flood_table() : 0,
          .area_tolerance = area_tolerance(settings.samples),
          .enlargement = settings.enlargement,
          .max_jumps = settings.max_jumps,
          .begin_sample = 0,
          .end_sample = settings.samples,
          .marks_only = 0,
          .unused_0 = 0,
          .unused_1 = 0};
}

// Binds the inputs of one program other than the geometry buffer.
void Evaluator::bind(const Gl &gl, const EvaluateSettings &settings) const {
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, used_centers_);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULTS, results_.id());
  if (settings.relocation != PDESC_RELOCATION_CONNECTED) {
    bind_march(gl);
  } else {
    settings.search->bind(gl);
    settings.cells->bind(gl);
    settings.connected->bind(gl);
    if (settings.points) gl.BindTextureUnit(UNIT_POINTS, settings.points->id());
  }
  if (settings.map) {
    settings.map->bind();
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MAP_CENTERS, map_centers_.id());
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MAP_TEXELLESS, map_texelless_.id());
  }
  if (settings.faces()) gl.BindTextureUnit(UNIT_FACES, faces_);
}

void Evaluator::use_params(const Gl &gl, const EvaluateParams &params) {
  params_.fill(gl, &params, sizeof params, GL_STREAM_DRAW);
  gl.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_EVALUATE, params_.id());
}

GLuint Evaluator::use_program(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer,
                              const EvaluateSettings &settings) const {
  const bool texelless = settings.search && settings.cells->has_texelless();
  const GLuint program = evaluate_program(gl, programs, settings, buffer.variant(), texelless);
  gl.UseProgram(program);
  buffer.bind();
  gl.Uniform1i(LOCATION_BUFFER_SIZE, buffer.size());
  gl.Uniform1f(LOCATION_AREA_UNIT, buffer.area_unit());
  return program;
}

void Evaluator::run(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const EvaluateSettings &settings,
                    int first, int last) {
  const bool marches = settings.relocation != PDESC_RELOCATION_CONNECTED;
  for (int end = first; first < last; first = end) {
    end = std::min(first + settings.most_centers(), last);
    const EvaluateParams params = params_of(settings, first, end);
    use_params(gl, params);
    if (marches && settings.ellipse == PDESC_ELLIPSE_DIRECTIONAL) find_stretches(gl, programs, buffer, params);
    bind(gl, settings);
    if (settings.search) settings.search->run(gl, programs, *settings.cells, false, end - first);
    const GLuint program = use_program(gl, programs, buffer, settings);
    if (marches)
      dispatch_marches(gl, program, settings, params);
    else
      gl.DispatchCompute(group_count(gl, end - first), 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    if (end < last) gl.Flush();
  }
  gl.Finish();
  check_gl(gl, "evaluate");
}

void Evaluator::check(const Gl &gl, ProgramCache &programs, const GeometryBuffer &buffer, const DeviceSurface &surface,
                      EvaluateSettings settings, int first, int last) {
  const ConnectedTriangles &connected = *settings.connected;
  settings.exact = true;
  for (int end = first; first < last; first = end) {
    end = std::min(first + connected.slots(), last);
    use_params(gl, params_of(settings, first, end));
    bind(gl, settings);
    connected.flood(gl, programs, surface, end - first);
    use_params(gl, params_of(settings, 0, end - first));
    settings.search->run(gl, programs, *settings.cells, true, end - first);
    use_program(gl, programs, buffer, settings);
    gl.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, connected.list());
    gl.DispatchComputeIndirect(CONNECTED_AGAIN_GROUPS * sizeof(int32_t));
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
  }
  gl.Finish();
  check_gl(gl, "connected triangles");
}

// Reads everything at once, so that the device is waited for only once.
void Evaluator::read(const Gl &gl, const EvaluateSettings &settings, Evaluated &read) const {
  const size_t values = result_values(settings, count_);
  read.rows.resize(values + counts_read);
  const auto behind = static_cast<GLintptr>(values * sizeof(float));
  if (settings.search) gl.CopyNamedBufferSubData(settings.cells->counts(), results_.id(), 0, behind, sizeof(SearchCounts));
  if (settings.connected)
    gl.CopyNamedBufferSubData(settings.connected->list(), results_.id(), CONNECTED_AMBIGUOUS * sizeof(int32_t),
                              behind + static_cast<GLintptr>(sizeof(SearchCounts)), 2 * sizeof(int32_t));
  gl.GetNamedBufferSubData(results_.id(), 0, static_cast<GLsizeiptr>(read.rows.size() * sizeof(float)), read.rows.data());
  check_gl(gl, "read-back");
  if (settings.search) std::memcpy(&read.counts, read.rows.data() + values, sizeof read.counts);
  read.ambiguous = read.patches = 0;
  if (settings.connected) {
    read.ambiguous = std::bit_cast<int32_t>(read.rows[values + counts_read - 2]);
    read.patches = std::bit_cast<int32_t>(read.rows.back());
  }
  read.rows.resize(values);
}

} // namespace paradesc
