// The data path in reading order: prepare → bake → evaluate → gather. compute() is its table of contents.
#include "compute/compute.h"

#include <numeric>

#include "compute/passes.h"
#include "descriptor/registry.h"
#include "engine/opengl/stages.h"
#include "engine/reference/reference.h"
#include "memory.h"
#include "support/cancel.h"
#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {

static void measure(Mesh &mesh) {
  constexpr int block = 65536;
  mesh.box = bounding_box(mesh.triangles, mesh.half_edges, mesh.context->threads);
  mesh.diagonal = length(mesh.box.high - mesh.box.low);
  const int half_edges = 3 * mesh.triangles.triangle_count;
  std::vector<std::pair<double, int>> parts(static_cast<size_t>((half_edges + block - 1) / block)); // sum and count
  parallel_blocks(half_edges, mesh.context->threads, block, [&](int begin, int end) {
    auto &[sum, count] = parts[begin / block];
    for (int h = begin; h < end; ++h) {
      // Each edge once: a pair by its lower half-edge.
      const int32_t twin = mesh.half_edges.twin[h];
      if (mesh.half_edges.corner_point[h] < 0 || (twin >= 0 && twin < h)) continue;
      auto at = [&](int c) { return dvec3(mesh.triangles.positions[mesh.triangles.corner_vertex[c]]); };
      sum += length(at(next_corner(h)) - at(h));
      ++count;
    }
  });
  double sum = 0.0;
  int count = 0;
  for (const auto &[part, edges] : parts) {
    sum += part;
    count += edges;
  }
  mesh.mean_edge = count ? sum / count : 0.0;
}

// Triangles that devices tell apart: shaders carry their numbers in floats, too.
static void check_triangle_count(const Context &context, int32_t triangles) {
  constexpr int32_t most = 1 << 24;
  if (context.gl && triangles > most)
    throw Error(PDESC_ERROR_UNSUPPORTED, "The mesh has " + std::to_string(triangles) + " triangles, and graphics devices take " +
                                             std::to_string(most) + "; use fewer, or the reference backend.");
}

std::unique_ptr<Mesh> make_mesh(std::shared_ptr<Context> context, const pdesc_mesh_input &input) {
  check_memory_of_input(*context, input);
  if (context->asked != PDESC_BACKEND_AUTO) check_triangle_count(*context, input.triangle_count);
  const CancelScope cancel([&] {
    if (input.progress && !input.progress(input.user, "mesh", 0.0))
      throw Error(PDESC_ERROR_CANCELLED, "Cancelled in stage mesh.");
  });
  auto mesh = std::make_unique<Mesh>();
  mesh->context = std::move(context);
  mesh->triangles = read_triangles(input);
  checkpoint();
  mesh->half_edges = build_half_edges(mesh->triangles, mesh->context->threads);
  mesh->charts = build_charts(mesh->triangles, mesh->half_edges, {}, mesh->context->threads);
  checkpoint();
  measure(*mesh);
  mesh->found = describe(*mesh);
  return mesh;
}

static void drop_device(Mesh &mesh) {
  if (mesh.device) mesh.gl->run([&](const Gl &, ProgramCache &) { mesh.device.reset(); });
}

Mesh::~Mesh() { drop_device(*this); }

void move_mesh(Mesh &mesh, const float *positions, int32_t vertex_count) {
  set_positions(mesh.triangles, positions, vertex_count);
  ++mesh.version;
  weigh_sites(mesh.triangles, mesh.context->threads, mesh.charts);
  measure(mesh);
}

void check_cancel(const Progress &progress, const char *stage, double fraction) {
  if (!progress(stage, fraction)) throw Error(PDESC_ERROR_CANCELLED, std::string("Cancelled in stage ") + stage + ".");
}

static double resolve_radius(const Mesh &mesh, const pdesc_options &options) {
  const double unit = options.radius_unit == PDESC_RADIUS_DIAGONAL    ? mesh.diagonal
                      : options.radius_unit == PDESC_RADIUS_MEAN_EDGE ? mesh.mean_edge
                                                                      : 1.0;
  const double radius = options.radius * unit;
  if (radius > mesh.diagonal)
    throw Error(PDESC_ERROR_INVALID_ARGUMENT, "The radius is " + std::to_string(radius) + ", but the mesh's diagonal is only " +
                                                  std::to_string(mesh.diagonal) + "; choose a smaller radius.");
  return radius;
}

static void warn(const Mesh &mesh, Field &field) {
  auto add = [&](const std::string &sentence) { field.warnings += (field.warnings.empty() ? "" : "\n") + sentence; };
  const pdesc_field_report &report = field.report;
  if (mesh.context->given_up)
    add(std::string("The graphics device failed, and ") + mesh.context->device.load() +
        " computed instead: " + mesh.context->fallback.load());
  if (report.backend == PDESC_BACKEND_REFERENCE) return;
  if (report.private_layout == PDESC_LAYOUT_OVERLAPS)
    add("Charts of the UV map share texture space" +
        (report.cut_charts > 0 ? ", " + std::to_string(report.cut_charts) + " of them with themselves and cut for that"
                               : std::string()) +
        "; they were laid out afresh for the computation, and the UV map itself is unchanged.");
  if (report.private_layout == PDESC_LAYOUT_SPARSE)
    add("The UV map uses little of its square; its charts were laid out afresh for the computation, and the UV map itself is "
        "unchanged.");
  if (report.radius_in_texels < 4.0)
    add("The radius spans only " + std::to_string(report.radius_in_texels).substr(0, 4) +
        " texels of the buffers; use larger buffers or a larger radius.");
  if (report.bare_triangles > 0)
    add(std::to_string(report.bare_triangles) +
        " triangles are smaller than a texel and left to their neighbors; use larger buffers if "
        "that is much of the surface.");
  if (mesh.charts.zero_uv_area_triangles > 0)
    add(std::to_string(mesh.charts.zero_uv_area_triangles) +
        " triangles have next to no area in the UV map; each counts by samples of its own, less finely than texels would.");
  if (report.low_coverage_vertices > 0)
    add("At " + std::to_string(report.low_coverage_vertices) +
        " vertices more than a tenth of the neighborhood was not found in the UV map.");
}

static SiteResults compute_in_texture_space(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, double radius,
                                            const Progress &progress, Field &field) {
  Clock clock;
  Frame &frame = prepare_frame(mesh, options);
  part_crowded(mesh);
  field.report.seconds_prepare = clock.lap();
  check_cancel(progress, "bake", 0.1);

  prepare_and_bake(mesh, options, radius, frame);
  if (lay_out_afresh(mesh, frame.radius_in_texels)) {
    mesh.device->grid.size = 0;
    prepare_and_bake(mesh, options, radius, frame);
  }
  field.report.private_layout = mesh.private_layout;
  field.report.cut_charts = mesh.cut_charts;
  field.report.seconds_bake = clock.lap();
  check_cancel(progress, "prepare", 0.2);

  const bool connected = options.relocation == PDESC_RELOCATION_CONNECTED, at_texels = options.evaluate == PDESC_EVALUATE_TEXEL;
  if (connected) build_cells_for(mesh, options, frame);
  field.report.seconds_prepare += clock.lap();
  check_cancel(progress, "evaluate", 0.3);

  const double radius_in_texels = frame.radius_in_texels;
  SiteResults results = at_texels ? evaluate_at_texels(mesh, options, asked, radius, frame, progress, field)
                                  : evaluate_at_vertices(mesh, options, asked, radius, frame, progress, field);
  field.report.overlapping_texels = mesh.device->counts.overlapping;
  field.report.covered_texels = mesh.device->counts.covered;
  field.report.bare_triangles = mesh.device->bare_triangles;
  field.report.radius_in_texels = radius_in_texels;
  field.report.buffer_megabytes = mesh.device->buffer->megabytes();
  field.report.refined_share = results.refined_share;
  field.report.seconds_evaluate = clock.lap();
  return results;
}

static SiteResults compute_in_object_space(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, double radius,
                                           const Progress &progress, Field &field) {
  Clock clock;
  const Normals normals = prepare_normals(mesh, options.normals);
  field.report.seconds_prepare = clock.lap();
  ReferenceSettings settings{radius, options.estimator, options.distance == PDESC_DISTANCE_GEODESIC};
  settings.map_radius = radius;
  settings.harris_k = options.harris_k;
  const auto points = static_cast<size_t>(mesh.half_edges.point_count);
  SiteResults results =
      run_passes(mesh.half_edges.point_count, asked, find_map(options.map_descriptor),
                 [&](const Pass &asked_now, const MapValues *map, int number, int count) {
                   settings.map = map;
                   settings.radius = reach_of(asked_now, options, radius);
                   settings.map_sigma = asked_now.stage == Stage::windows ? options.map_sigma * radius : 0.0;
                   ReferenceField reference = compute_reference(
                       mesh.triangles, mesh.half_edges, normals, settings, asked_now.rows, mesh.context->threads,
                       [&](double fraction) { return progress("evaluate", (number + fraction) / count); });
                   SiteResults pass;
                   pass.values = std::move(reference.values);
                   pass.boundary = std::move(reference.boundary);
                   pass.point.resize(points);
                   std::iota(pass.point.begin(), pass.point.end(), 0);
                   pass.primary.assign(points, 1);
                   pass.coverage.assign(points, 1.0f);
                   return pass;
                 });
  check_cancel(progress, "evaluate", 1.0); // other threads may have finished the last points
  field.report.places = mesh.half_edges.point_count;
  field.report.refined_share = 1.0;
  field.report.seconds_evaluate = clock.lap();
  return results;
}

static Field compute_on_backend(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, const Progress &progress) {
  const bool reference = mesh.context->backend == PDESC_BACKEND_REFERENCE;
  if (!reference && mesh.triangles.corner_uv.empty())
    throw Error(PDESC_ERROR_INVALID_OPERATION,
                "The mesh has no UV map, which texture space needs; unwrap it, or use the reference backend.");
  if (reference && mesh.maps.any())
    throw Error(
        PDESC_ERROR_INVALID_OPERATION,
        "Displacement and normal maps live in texture space, which the reference backend does without; take the maps away, "
        "or use the gpu or software backend.");
  check_triangle_count(*mesh.context, mesh.triangles.triangle_count);
  Clock clock;
  Field field;
  const double radius = resolve_radius(mesh, options);
  const char *stage = "prepare";
  double reached = 0.0;
  const Progress told = [&](const char *name, double fraction) { return progress(stage = name, reached = fraction); };
  const CancelScope cancel([&] { check_cancel(progress, stage, reached); });
  check_cancel(told, stage, reached);
  const SiteResults results = reference ? compute_in_object_space(mesh, options, asked, radius, told, field)
                                        : compute_in_texture_space(mesh, options, asked, radius, told, field);
  checkpoint();
  for (const int descriptor : asked) field.names.emplace_back(descriptors()[descriptor].name);
  gather(mesh.half_edges, results, options.seam_error != 0 && !reference, mesh.context->threads, field);
  field.report.radius = radius;
  field.report.backend = mesh.context->backend;
  field.report.memory_megabytes =
      1e-6 * static_cast<double>(total_of(memory_of_compute(mesh, field.report.backend, options, asked), field.report.backend));
  field.report.seconds_total = clock.lap();
  warn(mesh, field);
  return field;
}

// The mesh goes where the context computes now.
static void take_device(Mesh &mesh) {
  reopen_lost_device(*mesh.context);
  if (mesh.gl == mesh.context->gl) return;
  drop_device(mesh);
  mesh.gl = mesh.context->gl;
}

// What a device fails to compute is computed on the next one, where AUTO was asked for.
Field compute(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, const Progress &progress) {
  check_memory_of_compute(mesh, options, asked);
  while (true) {
    try {
      take_device(mesh);
      return compute_on_backend(mesh, options, asked, progress);
    } catch (const Error &error) {
      if (!mesh.gl || !is_of_device(error)) throw;
      drop_device(mesh); // half of it may be missing
      if (!fall_back(*mesh.context, error)) throw;
      if (!mesh.context->gl && mesh.maps.any()) throw; // which only a device can follow
    }
  }
}

} // namespace paradesc
