// The C edge and nothing else: checks handles and arguments. api_edge.h turns exceptions into codes and sentences.
#include <cmath>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "api_edge.h"
#include "compute/choice.h"
#include "compute/compute.h"
#include "compute/memory.h"
#include "descriptor/passes.h"
#include "descriptor/registry.h"
#include "mesh/near_seam.h"
#include "support/error.h"
#include "support/free_memory.h"
#include "support/live.h"
#include "support/shown.h"

paradesc::edge::LastError &paradesc::edge::last_error() {
  thread_local LastError sentence;
  return sentence;
}

struct pdesc_context {
  std::shared_ptr<paradesc::Context> context;
};
struct pdesc_mesh {
  std::unique_ptr<paradesc::Mesh> mesh;
};
struct pdesc_field {
  paradesc::Field field;
};

namespace {

using namespace paradesc::edge;
using paradesc::Error;
using paradesc::shown;

// Never destroyed: other threads may still call while the process ends.
paradesc::LiveHandles &live() {
  static auto *handles = new paradesc::LiveHandles;
  return *handles;
}

template <class Handle> void need_live(const Handle *handle, const char *name) {
  need(handle, name);
  if (!live().contains(handle))
    refuse(std::string("The argument '") + name + "' is no " + name + ", or one that was destroyed; pass one that is alive.");
}

// One call at a time on a context, whose workers help with it. Refuses a call from inside the progress callback of another call
// on the same context, which would wait for itself.
class Turn {
public:
  explicit Turn(paradesc::Context &context) : context_(context) {
    if (context_.holder == std::this_thread::get_id())
      throw Error(PDESC_ERROR_INVALID_OPERATION,
                  "This call comes from the progress callback of another on the same context; return from the callback first.");
    if (context_.process != paradesc::this_process() && context_.holder.load() != std::thread::id())
      throw Error(PDESC_ERROR_INVALID_OPERATION, "Another thread computed on this context while this process was forked, and is "
                                                 "not there any more; make another context.");
    context_.mutex.lock();
    context_.holder = std::this_thread::get_id();
    scope_.emplace(context_.workers);
  }
  ~Turn() {
    scope_.reset();
    context_.holder = std::thread::id();
    context_.mutex.unlock();
  }
  Turn(const Turn &) = delete;
  Turn &operator=(const Turn &) = delete;

private:
  paradesc::Context &context_;
  std::optional<paradesc::Workers::Scope> scope_;
};

constexpr const char *no_seam_errors =
    "Seam errors are not computed any more; leave the option seam_error 0, and compare with the backend reference near the seams "
    "that pdesc_mesh_near_seam finds.";

void check_options(const pdesc_options &options) {
  if (!std::isfinite(options.radius) || options.radius <= 0.0)
    refuse("The radius is " + shown(options.radius) + "; it must be a finite number above 0.");
  check_range("radius_unit", options.radius_unit, PDESC_RADIUS_DIAGONAL, PDESC_RADIUS_MEAN_EDGE);
  check_range("samples", options.samples, 8, 4096);
  check_range("buffer_size", options.buffer_size, 64, 8192);
  check_range("normals", options.normals, PDESC_NORMALS_FITTED, PDESC_NORMALS_MESH);
  check_range("creases", options.creases, PDESC_CREASES_AUTO, PDESC_CREASES_NONE);
  check_range("max_jumps", options.max_jumps, 0, 64);
  check_range("relocation", options.relocation, PDESC_RELOCATION_CONNECTED, PDESC_RELOCATION_PAPER);
  check_range("estimator", options.estimator, PDESC_ESTIMATOR_SHAPE_OPERATOR, PDESC_ESTIMATOR_EXTRAPOLATED);
  check_range("variance_reduction", options.variance_reduction, PDESC_VARIANCE_REDUCTION_SHAPE, PDESC_VARIANCE_REDUCTION_NONE);
  check_range("geodesic", options.geodesic, PDESC_GEODESIC_LOCAL, PDESC_GEODESIC_CHORDS);
  check_range("distance", options.distance, PDESC_DISTANCE_EUCLIDEAN, PDESC_DISTANCE_GEODESIC);
  check_range("pattern", options.pattern, PDESC_PATTERN_GOLDEN_ANGLE, PDESC_PATTERN_STRATIFIED);
  check_range("ellipse", options.ellipse, PDESC_ELLIPSE_CENTER, PDESC_ELLIPSE_DIRECTIONAL);
  check_range("evaluate", options.evaluate, PDESC_EVALUATE_VERTEX, PDESC_EVALUATE_TEXEL);
  check_range("texels", options.texels, 16, 8192);
  check_range("precision", options.precision, PDESC_PRECISION_FULL, PDESC_PRECISION_HALF);
  if (options.seam_error != 0) refuse(no_seam_errors);
  if (!std::isfinite(options.adaptive) || options.adaptive < 0.0)
    refuse("The option adaptive is " + shown(options.adaptive) + "; it must be a finite number from 0 on.");
  if (!(options.map_sigma >= 0.1) || !(options.map_sigma <= 4.0))
    refuse("The option map_sigma is " + shown(options.map_sigma) + "; choose from 0.1 to 4 radii.");
  if (!(options.harris_k >= 0.0) || !(options.harris_k < 0.25))
    refuse("The option harris_k is " + shown(options.harris_k) +
           "; it must be from 0 on and below 0.25, from which on no place is a corner.");
  paradesc::find_map(options.map_descriptor);
  if (options.geodesic == PDESC_GEODESIC_CHORDS && options.relocation == PDESC_RELOCATION_CONNECTED)
    refuse("The sum of chords follows straight ways in the UV map, which the connected relocation has not; choose the affine or "
           "the paper's relocation, or the local geodesic distance.");
}

std::vector<int> rows_of(const char *const *names, int32_t count) {
  need(names, "descriptors");
  check_range("descriptor_count", count, 1, pdesc_descriptor_count());
  std::vector<int> rows;
  for (int32_t i = 0; i < count; ++i) rows.push_back(paradesc::find_descriptor(names[i]));
  return rows;
}

void check_length(int32_t room, size_t needed) {
  if (room < 0 || static_cast<size_t>(room) != needed)
    refuse("The array has room for " + std::to_string(room) + " vertices, but the mesh has " + std::to_string(needed) + ".");
}

const std::vector<float> &column(const std::vector<std::string> &names, const std::vector<std::vector<float>> &columns,
                                 const char *name) {
  need(name, "name");
  for (size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return columns[i];
  std::string known;
  for (const std::string &one : names) known += (known.empty() ? "" : ", ") + one;
  refuse(std::string("This field has no '") + name + "'; it has " + known + ".");
}

void copy_texels(const std::vector<float> &texels, float *values, int64_t count) {
  if (count != static_cast<int64_t>(texels.size()))
    refuse("The array has room for " + std::to_string(count) + " floats, but " + std::to_string(texels.size()) + " are needed.");
  std::copy(texels.begin(), texels.end(), values);
}

} // namespace

int32_t pdesc_abi_version(void) { return PDESC_ABI_VERSION; }
const char *pdesc_version(void) { return PARADESC_VERSION; }
const char *pdesc_last_error(void) { return last_error().text(); }

void pdesc_descriptor_info_init(pdesc_descriptor_info *info) { zero_init(info); }

int32_t pdesc_descriptor_count(void) { return static_cast<int32_t>(paradesc::descriptors().size()); }

int32_t pdesc_descriptor_get(int32_t index, pdesc_descriptor_info *info) {
  return guarded([&] {
    check_range("index", index, 0, pdesc_descriptor_count() - 1);
    const auto &row = paradesc::descriptors()[index];
    pdesc_descriptor_info ours;
    zero_init(&ours);
    ours.name = row.name;
    ours.label = row.label;
    ours.description = row.description;
    ours.length_power = row.length_power;
    ours.is_signed = row.is_signed;
    ours.neutral_value = row.neutral;
    ours.display_minimum = row.display_minimum;
    ours.display_maximum = row.display_maximum;
    ours.components = row.components;
    ours.map_degree = row.map_degree;
    write_struct(ours, info, "pdesc_descriptor_info");
  });
}

void pdesc_context_options_init(pdesc_context_options *options) {
  zero_init(options);
  if (options) options->device_index = -1;
}

int32_t pdesc_context_create(const pdesc_context_options *options, pdesc_context **context) {
  return guarded([&] {
    need(context, "context");
    const auto ours = read_struct(options, pdesc_context_options_init, "pdesc_context_options");
    check_range("backend", ours.backend, PDESC_BACKEND_AUTO, PDESC_BACKEND_CPU);
    check_range("device_index", ours.device_index, -1, 1023);
    check_range("threads", ours.threads, 0, 4096);
    check_range("memory_limit", ours.memory_limit, 0, INT64_MAX);
    *context = live().add(std::unique_ptr<pdesc_context>(new pdesc_context{paradesc::make_context(ours)}));
  });
}

void pdesc_context_destroy(pdesc_context *context) {
  if (live().remove(context)) delete context;
}
int32_t pdesc_context_backend(const pdesc_context *context) {
  return live().contains(context) ? context->context->backend : PDESC_BACKEND_AUTO;
}
const char *pdesc_context_device(const pdesc_context *context) {
  return live().contains(context) ? context->context->device.load() : "";
}
const char *pdesc_context_fallback(const pdesc_context *) { return ""; }

void pdesc_mesh_input_init(pdesc_mesh_input *input) { zero_init(input); }
void pdesc_mesh_report_init(pdesc_mesh_report *report) { zero_init(report); }

int32_t pdesc_mesh_create(pdesc_context *context, const pdesc_mesh_input *input, pdesc_mesh **mesh) {
  return guarded([&] {
    need_live(context, "context");
    need(input, "input");
    need(mesh, "mesh");
    const auto ours = read_struct(input, pdesc_mesh_input_init, "pdesc_mesh_input");
    *mesh = live().add(std::unique_ptr<pdesc_mesh>(new pdesc_mesh{paradesc::make_mesh(context->context, ours)}));
  });
}

int32_t pdesc_mesh_set_positions(pdesc_mesh *mesh, const float *positions, int32_t vertex_count) {
  return guarded([&] {
    need_live(mesh, "mesh");
    need(positions, "positions");
    const Turn turn(*mesh->mesh->context);
    paradesc::move_mesh(*mesh->mesh, positions, vertex_count);
  });
}

int32_t pdesc_mesh_set_displacement(pdesc_mesh *mesh, const float *heights, int32_t width, int32_t height, double midlevel,
                                    double scale) {
  return guarded([&] {
    need_live(mesh, "mesh");
    const Turn turn(*mesh->mesh->context);
    paradesc::set_displacement(mesh->mesh->maps, mesh->mesh->triangles, heights, width, height, midlevel, scale);
  });
}

int32_t pdesc_mesh_set_normal_map(pdesc_mesh *mesh, const float *rgb, int32_t width, int32_t height, const float *corner_tangents,
                                  int32_t corner_count) {
  return guarded([&] {
    need_live(mesh, "mesh");
    const Turn turn(*mesh->mesh->context);
    paradesc::set_normal_map(mesh->mesh->maps, mesh->mesh->triangles, rgb, width, height, corner_tangents, corner_count);
  });
}

int32_t pdesc_mesh_get_report(const pdesc_mesh *mesh, pdesc_mesh_report *report) {
  return guarded([&] {
    need_live(mesh, "mesh");
    const Turn turn(*mesh->mesh->context);
    write_struct(paradesc::report_of(*mesh->mesh), report, "pdesc_mesh_report");
  });
}

int32_t pdesc_mesh_near_seam(const pdesc_mesh *mesh, double radius, uint8_t *near_seam, int32_t vertex_count) {
  return guarded([&] {
    need_live(mesh, "mesh");
    need(near_seam, "near_seam");
    if (!std::isfinite(radius) || radius < 0.0)
      refuse("The radius is " + shown(radius) + "; it must be a finite number from 0 on.");
    const Turn turn(*mesh->mesh->context);
    const paradesc::Mesh &ours = *mesh->mesh;
    check_length(vertex_count, static_cast<size_t>(ours.triangles.vertex_count));
    const auto near = paradesc::vertices_near_seams(ours.triangles, ours.half_edges, ours.atlases.current().charts, radius);
    std::copy(near.begin(), near.end(), near_seam);
  });
}

void pdesc_mesh_destroy(pdesc_mesh *mesh) {
  if (!mesh) return;
  guarded([&] {
    need_live(mesh, "mesh");
    const auto context = mesh->mesh->context; // keeps the context until the turn ends
    const Turn turn(*context);
    if (live().remove(mesh)) delete mesh;
  });
}

void pdesc_options_init(pdesc_options *options) {
  zero_init(options);
  if (!options) return;
  options->radius = 0.02;
  options->samples = 256;
  options->buffer_size = 1024;
  options->max_jumps = 8;
  options->texels = 512;
  options->map_sigma = 1.0;
  options->harris_k = 0.04;
}

int32_t pdesc_compute(pdesc_mesh *mesh, const pdesc_options *options, const char *const *names, int32_t count,
                      pdesc_progress progress, void *user, pdesc_field **field) {
  return guarded([&] {
    need_live(mesh, "mesh");
    need(field, "field");
    const auto ours = read_struct(options, pdesc_options_init, "pdesc_options");
    check_options(ours);
    const std::vector<int> requested = rows_of(names, count);
    const Turn turn(*mesh->mesh->context);
    auto result = std::make_unique<pdesc_field>();
    result->field = paradesc::compute(*mesh->mesh, ours, requested, paradesc::progress_of(progress, user));
    *field = live().add(std::move(result));
  });
}

void pdesc_memory_init(pdesc_memory *memory) { zero_init(memory); }

int32_t pdesc_mesh_memory(const pdesc_mesh *mesh, const pdesc_options *options, const char *const *names, int32_t count,
                          int32_t backend, pdesc_memory *memory) {
  return guarded([&] {
    need_live(mesh, "mesh");
    check_range("backend", backend, PDESC_BACKEND_AUTO, PDESC_BACKEND_CPU);
    const auto ours = read_struct(options, pdesc_options_init, "pdesc_options");
    check_options(ours);
    const std::vector<int> requested = rows_of(names, count);
    const Turn turn(*mesh->mesh->context);
    const paradesc::Context &context = *mesh->mesh->context;
    if (backend == PDESC_BACKEND_AUTO) backend = paradesc::backend_for(context, ours);
    const paradesc::MemoryForecast needed = paradesc::forecast_memory_of(*mesh->mesh, backend, ours, requested);
    pdesc_memory found{};
    found.mesh = needed.mesh;
    found.host = needed.host;
    found.device = needed.device;
    found.total = needed.total();
    const int64_t allowed = paradesc::allowed_memory(context.memory_limit, needed.mesh);
    found.allowed = allowed > INT64_MAX - needed.mesh ? INT64_MAX : needed.mesh + allowed;
    write_struct(found, memory, "pdesc_memory");
  });
}

int32_t pdesc_mesh_backend(const pdesc_mesh *mesh, const pdesc_options *options, int32_t *backend) {
  return guarded([&] {
    need_live(mesh, "mesh");
    need(backend, "backend");
    const auto ours = read_struct(options, pdesc_options_init, "pdesc_options");
    check_options(ours);
    const Turn turn(*mesh->mesh->context);
    *backend = paradesc::backend_for(*mesh->mesh->context, ours);
  });
}

int32_t pdesc_mesh_buffer_size(const pdesc_mesh *mesh) {
  int32_t size = 0;
  guarded([&] {
    need_live(mesh, "mesh");
    const Turn turn(*mesh->mesh->context);
    size = paradesc::buffer_size(*mesh->mesh);
  });
  return size;
}

int32_t pdesc_mesh_read_buffer(pdesc_mesh *mesh, const char *name, float *values, int64_t count) {
  return guarded([&] {
    need_live(mesh, "mesh");
    need(name, "name");
    need(values, "values");
    const Turn turn(*mesh->mesh->context);
    copy_texels(paradesc::read_buffer(*mesh->mesh, name).values, values, count);
  });
}

int32_t pdesc_mesh_layout(const pdesc_mesh *mesh, float *uvs, int32_t triangle_count) {
  return guarded([&] {
    need_live(mesh, "mesh");
    need(uvs, "uvs");
    const Turn turn(*mesh->mesh->context);
    const auto &corners = mesh->mesh->atlases.current().charts.corner_uv;
    if (corners.empty()) throw Error(PDESC_ERROR_INVALID_OPERATION, "The mesh has no UV map, and so no layout.");
    if (triangle_count != mesh->mesh->triangles.triangle_count)
      refuse("The array has room for " + std::to_string(triangle_count) + " triangles, but the mesh has " +
             std::to_string(mesh->mesh->triangles.triangle_count) + ".");
    for (size_t i = 0; i < corners.size(); ++i) {
      uvs[2 * i] = corners[i].x;
      uvs[2 * i + 1] = corners[i].y;
    }
  });
}

void pdesc_field_report_init(pdesc_field_report *report) { zero_init(report); }

int32_t pdesc_field_get_report(const pdesc_field *field, pdesc_field_report *report) {
  return guarded([&] {
    need_live(field, "field");
    write_struct(field->field.report, report, "pdesc_field_report");
  });
}

const char *pdesc_field_warnings(const pdesc_field *field) { return live().contains(field) ? field->field.warnings.c_str() : ""; }

const char *pdesc_field_device(const pdesc_field *field) { return live().contains(field) ? field->field.device.c_str() : ""; }

int32_t pdesc_field_values(const pdesc_field *field, const char *name, float *values, int32_t vertex_count) {
  return guarded([&] {
    need_live(field, "field");
    need(values, "values");
    const auto &ours = column(field->field.names, field->field.values, name);
    check_length(vertex_count, field->field.mask.size());
    std::copy(ours.begin(), ours.end(), values);
  });
}

int32_t pdesc_field_seam_error(const pdesc_field *field, const char *, float *values, int32_t) {
  return guarded([&] {
    need_live(field, "field");
    need(values, "values");
    throw Error(PDESC_ERROR_INVALID_OPERATION, no_seam_errors);
  });
}

int32_t pdesc_field_mask(const pdesc_field *field, uint8_t *mask, int32_t vertex_count) {
  return guarded([&] {
    need_live(field, "field");
    need(mask, "mask");
    check_length(vertex_count, field->field.mask.size());
    std::copy(field->field.mask.begin(), field->field.mask.end(), mask);
  });
}

int32_t pdesc_field_map_size(const pdesc_field *field) { return live().contains(field) ? field->field.map_size : 0; }

int32_t pdesc_field_map(const pdesc_field *field, const char *name, float *values, int64_t count) {
  return guarded([&] {
    need_live(field, "field");
    need(values, "values");
    if (field->field.maps.empty())
      throw Error(PDESC_ERROR_INVALID_OPERATION,
                  "This field has no map; compute with evaluate = TEXEL on a backend other than the reference.");
    std::vector<std::string> names = field->field.names;
    names.emplace_back("boundary");
    copy_texels(column(names, field->field.maps, name), values, count);
  });
}

void pdesc_field_destroy(pdesc_field *field) {
  if (live().remove(field)) delete field;
}
