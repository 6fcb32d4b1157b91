// The spine: normals → the engine's samples, neighborhoods and sums → a value at every vertex. Read compute_on_engine() as the
// table of contents.
#include "compute/compute.h"

#include <string>

#include "compute/choice.h"
#include "compute/evaluate.h"
#include "compute/memory.h"
#include "compute/refine.h"
#include "support/cancel.h"
#include "support/error.h"
#include "support/shown.h"

namespace paradesc {

static double resolve_radius(const Mesh &mesh, const pdesc_options &options) {
  const double radius = requested_radius(mesh, options);
  if (radius > mesh.box.diagonal())
    throw Error(PDESC_ERROR_INVALID_ARGUMENT, "The radius is " + shown(radius) + ", but the mesh's diagonal is only " +
                                                  shown(mesh.box.diagonal()) + "; choose a smaller radius.");
  return radius;
}

static void warn(const Mesh &mesh, const pdesc_options &options, Field &field) {
  auto add = [&](const std::string &sentence) { field.warnings += (field.warnings.empty() ? "" : "\n") + sentence; };
  const pdesc_field_report &report = field.report;
  if (mesh.engine != mesh.context->engine)
    add("Only texture space has " + texture_space_needs(options) + ", so " + mesh.engine->device() +
        " computed instead of the processor.");
  if (const auto *division = mesh.division.key() ? &mesh.division.value() : nullptr; division && division->plan.coarsening > 1.0f)
    add("The surface maps have more pixels than the surface was divided into (" + std::to_string(division->plan.pieces()) +
        " triangles), so their finest details are missing; use smaller images or a larger radius.");
  if (report.private_layout == PDESC_LAYOUT_OVERLAPS)
    add("Charts of the UV map share texture space" +
        (report.cut_charts > 0 ? ", " + std::to_string(report.cut_charts) + " of them with themselves and cut for that"
                               : std::string()) +
        "; they were laid out afresh for the computation, and the UV map itself is unchanged.");
  if (report.private_layout == PDESC_LAYOUT_SPARSE)
    add("The UV map uses little of its square, or gives the radius few texels in one direction; its charts were laid out afresh "
        "for the computation, and the UV map itself is unchanged.");
  if (!abilities_of(report.backend).texture_space) return;
  if (report.radius_in_texels < 4.0)
    add("The radius spans only " + std::to_string(report.radius_in_texels).substr(0, 4) +
        " texels of the buffers in the direction that has the fewest; use larger buffers, a larger "
        "radius or the cpu backend.");
  if (report.bare_triangles > 0)
    add(std::to_string(report.bare_triangles) +
        " triangles are smaller than a texel and left to their neighbors; use larger buffers if "
        "that is much of the surface.");
  if (mesh.atlases.current().charts.zero_uv_area_triangles > 0)
    add(std::to_string(mesh.atlases.current().charts.zero_uv_area_triangles) +
        " triangles have next to no area in the UV map; samples are not carried over them, and what lies there is not found.");
  if (report.low_coverage_vertices > 0)
    add("At " + std::to_string(report.low_coverage_vertices) +
        " vertices more than a tenth of the neighborhood was not found in the UV map.");
}

static Surface surface_of(Mesh &mesh, const pdesc_options &options) {
  Surface surface{mesh.triangles,
                  mesh.half_edges,
                  normals_of(mesh, options),
                  options.creases == PDESC_CREASES_NONE ? nullptr : &creases_of(mesh, options),
                  mesh.maps,
                  mesh.box,
                  mesh.atlases,
                  mesh.positions_version};
  surface.facets = [&]() -> const Facets & { return facets_of(mesh, options); };
  return surface;
}

static Field compute_on_engine(Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors,
                               const Progress &progress) {
  refuse_beyond_abilities(mesh, options);
  Clock clock, stages;
  const Request request{options, descriptors, resolve_radius(mesh, options)};
  const char *stage = "prepare";
  double reached = 0.0;
  const Progress reported = [&](const char *name, double fraction) { return progress(stage = name, reached = fraction); };
  const CancelScope cancel([&] { check_cancel(progress, stage, reached); });
  check_cancel(reported, stage, reached);

  const bool divided = is_divided(mesh, mesh.engine->backend());
  if (!divided) forget_refined_surface(mesh);
  const Surface surface = divided ? refined_surface_of(mesh, options) : surface_of(mesh, options);
  const double seconds_surface = stages.lap();
  Field field;
  const CenterResults results = evaluate(mesh, surface, request, reported, field);
  checkpoint();
  gather(mesh.half_edges, results, descriptors, mesh.context->threads, field);
  field.report.radius = request.radius;
  if (options.creases != PDESC_CREASES_NONE)
    field.report.crease_edges = static_cast<int32_t>(creases_of(mesh, options).edges.size());
  field.report.backend = mesh.engine->backend();
  field.device = mesh.engine->device();
  const MemoryForecast memory = forecast_memory_of(mesh, field.report.backend, options, descriptors);
  field.report.memory_megabytes = 1e-6 * static_cast<double>(memory.total());
  mesh.memory_held = abilities_of(field.report.backend).texture_space ? memory.total() : 0; // other engines keep next to nothing
  field.report.seconds_prepare += seconds_surface;
  field.report.seconds_total = clock.lap();
  warn(mesh, options, field);
  return field;
}

// Returns whether the device failed, as opposed to bad input or a caller who cancelled.
static bool is_of_device(const Error &error) {
  return error.status() == PDESC_ERROR_UNSUPPORTED || error.status() == PDESC_ERROR_OUT_OF_MEMORY ||
         error.status() == PDESC_ERROR_DEVICE_LOST || error.status() == PDESC_ERROR_UNKNOWN;
}

Field compute(Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors, const Progress &progress) {
  {
    const CancelScope cancel([&] { check_cancel(progress, "prepare", 0.0); });
    check_memory_of_compute(mesh, options, descriptors);
  }
  try {
    take_engine(mesh, options);
    return compute_on_engine(mesh, options, descriptors, progress);
  } catch (const Error &error) {
    if (is_of_device(error)) mesh.session.reset(); // it may be half made
    throw;
  }
}

} // namespace paradesc
