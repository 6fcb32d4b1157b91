// Forecasts memory from the lengths of arrays. The factors agree with `tests/bench/memory.py`, which prints how far a peak is
// from this forecast.
#include "compute/memory.h"

#include <algorithm>
#include <cmath>

#include "compute/centers.h"
#include "compute/choice.h"
#include "compute/refine.h"
#include "descriptor/registry.h"
#include "engine/creases/blend.h"
#include "engine/engines.h"
#include "engine/memory.h"
#include "support/parallel.h"

namespace paradesc {

int64_t bytes_of_input(const pdesc_mesh_input &input) {
  const int64_t triangles = std::max(input.triangle_count, 0), vertices = std::max(input.vertex_count, 0);
  const int64_t edges = std::max(input.sharp_edge_count, 0);
  int64_t a_triangle = 224;               // corners, half-edges, charts, and lists of edges while these are found
  if (input.corner_uvs) a_triangle += 60; // as given, and mapped into the unit square
  if (input.corner_normals) a_triangle += 36;
  return triangles * a_triangle + vertices * 80 + edges * 8;
}

template <class... Lists> static int64_t bytes(const Lists &...lists) {
  return static_cast<int64_t>(((lists.capacity() * sizeof(lists[0])) + ...));
}

// UVs as given, in the unit square, and in the layout; they usually share one array.
static int64_t bytes_of_uvs(const Triangles &t, const Charts &c) {
  const int64_t one = static_cast<int64_t>(t.input_uv.size() * sizeof(vec2));
  return one * (1 + (t.corner_uv.begin() != t.input_uv.begin()) + (c.corner_uv.begin() != t.corner_uv.begin()));
}

// The bytes that a mesh holds between computations.
static int64_t bytes_of_mesh(const Mesh &mesh) {
  const Triangles &t = mesh.triangles;
  const HalfEdges &h = mesh.half_edges;
  const Charts &c = mesh.atlases.current().charts;
  return bytes(t.positions, t.corner_vertex, t.input_corner, t.corner_normal, t.half_edge_sharp) + bytes_of_uvs(t, c) +
         bytes(h.corner_point, h.twin, h.triangle_piece, h.point_vertex, h.point_half_edge, h.vertex_point, h.point_boundary) +
         bytes(mesh.steady_normals, c.triangle_chart, c.corner_wedge, c.half_edge_border, c.wedges, c.point_wedge, c.borders);
}

// Roughly how many disks of the radius cover the surface's area, taking it for a sphere of the same extent; 0 for a radius that
// no computation accepts.
static double disks_of(const Mesh &mesh, const pdesc_options &options) {
  const double part = requested_radius(mesh, options) / mesh.box.diagonal();
  return part > 1e-6 ? 1.0 / (3.0 * part * part) : 0.0;
}

// Bytes of normals and results, in addition to the mesh. The map that operators read is computed at the points of all pieces.
static int64_t bytes_of_results(const ComputationSize &size) {
  const int64_t points = reads_map(size.descriptors) ? size.piece_points : size.points;
  return 60 * size.triangles + 300 * size.points + 12 * rows_of(size.descriptors) * points;
}

// The memory for texels: centers in their first order and in that of the texels, results and images, and one band with the map's
// values at points.
static int64_t bytes_of_texels(const ComputationSize &size) {
  const int64_t texels = int64_t{size.options.texels} * size.options.texels, rows = rows_of(size.descriptors);
  const int64_t band = std::min<int64_t>(texels, texels_of_band) + size.piece_points;
  return texels * static_cast<int64_t>(8 + 2 * sizeof(TexelCenter)) + texels * 8 * rows +
         band * static_cast<int64_t>(sizeof(CenterPoint) + sizeof(vec4) + 16 + 8 * rows);
}

MemoryForecast forecast_memory_of(Mesh &mesh, int backend, const pdesc_options &options, std::span<const int> descriptors) {
  const Charts &charts = mesh.atlases.current().charts;
  const DivisionPlan *const plan = is_divided(mesh, backend) ? &division_plan_of(mesh, options) : nullptr;
  const int64_t triangles = mesh.triangles.triangle_count, points = mesh.half_edges.point_count;
  const ComputationSize size{triangles,
                             points,
                             static_cast<int64_t>(charts.wedges.size()),
                             static_cast<int64_t>(charts.borders.size()),
                             plan ? plan->pieces() : triangles,
                             plan ? points + plan->new_points() : points,
                             mesh.maps.any(),
                             disks_of(mesh, options),
                             thread_count(mesh.context->threads),
                             options,
                             descriptors};
  MemoryForecast memory = forecast_memory(backend, size);
  memory.host += bytes_of_results(size);
  if (options.creases != PDESC_CREASES_NONE) {
    const int64_t creases = triangles * bytes_of_creased_triangle(size.threads);
    memory.host += creases;
    memory.rough += creases;
  }
  if (options.evaluate == PDESC_EVALUATE_TEXEL && abilities_of(backend).texels) memory.host += bytes_of_texels(size);
  if (plan) memory.host += bytes_of_refined_surface(mesh, *plan);
  memory.mesh = bytes_of_mesh(mesh);
  return memory;
}

void check_memory_of_input(const Context &context, const pdesc_mesh_input &input) {
  check_memory(context.memory_limit,
               "A mesh of " + std::to_string(input.triangle_count) + " triangles and " + std::to_string(input.vertex_count) +
                   " vertices",
               "use fewer triangles", bytes_of_input(input), 0);
}

void check_memory_of_compute(Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors) {
  const int32_t backend = backend_for(*mesh.context, options);
  const MemoryForecast memory = forecast_memory_of(mesh, backend, options, descriptors);
  const bool divided = is_divided(mesh, backend);
  const bool buffers = abilities_of(backend).texture_space;
  const int64_t needed = memory.total() - memory.rough - memory.mesh;
  if (mesh.session && memory.total() <= mesh.memory_held) return;
  check_memory(mesh.context->memory_limit,
               "A computation on " + std::to_string(mesh.triangles.triangle_count) + " triangles" +
                   (divided ? ", divided into " + std::to_string(division_plan_of(mesh, options).pieces()) + " for surface maps,"
                    : buffers ? " with buffers of " + std::to_string(options.buffer_size) + " texels a side"
                              : std::string()),
               divided   ? "use smaller images or a larger radius"
               : buffers ? "use smaller buffers or fewer triangles"
                         : "use fewer triangles",
               needed, memory.mesh);
}

} // namespace paradesc
