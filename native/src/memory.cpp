// What arrays there are, times their lengths. The factors are those of `tests/bench/memory.py`, which prints how far a peak is
// from what is expected here.
#include "memory.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "descriptor/registry.h"
#include "compute/passes.h"
#include "support/free_memory.h"

#include "shared.h"

namespace paradesc {

int64_t bytes_of_input(const pdesc_mesh_input &input) {
  const int64_t triangles = std::max(input.triangle_count, 0), vertices = std::max(input.vertex_count, 0);
  const int64_t edges = std::max(input.sharp_edge_count, 0);
  int64_t a_triangle = 220;               // corners, half-edges, charts, and lists of edges while these are found
  if (input.corner_uvs) a_triangle += 60; // as given, and in the unit square
  if (input.corner_normals) a_triangle += 36;
  return triangles * a_triangle + vertices * 80 + edges * 8;
}

template <class... Lists> static int64_t bytes(const Lists &...lists) {
  return static_cast<int64_t>(((lists.capacity() * sizeof(lists[0])) + ...));
}

static int64_t bytes_of(const Patches &p) {
  return bytes(p.triangle_patch, p.begin, p.triangle, p.corner, p.point_begin, p.point, p.link_begin, p.link);
}

// What a mesh holds between computations.
static int64_t bytes_of_mesh(const Mesh &mesh) {
  const Triangles &t = mesh.triangles;
  const HalfEdges &h = mesh.half_edges;
  const Charts &c = mesh.charts;
  return bytes(t.positions, t.corner_vertex, t.corner_uv, t.given_uv, t.input_corner, t.corner_normal, t.half_edge_sharp) +
         bytes(h.corner_point, h.twin, h.point_vertex, h.point_half_edge, h.vertex_point, h.point_boundary) +
         bytes(c.triangle_chart, c.corner_site, c.half_edge_border, c.sites, c.point_site, c.shared_sites, c.shared_corners,
               c.borders) +
         (mesh.patches ? bytes_of(*mesh.patches) : 0);
}

// Cells of other radii, here and on the device: kept by chance, and so not a part of what one computation takes.
static int64_t bytes_of_other_cells(const Mesh &mesh) {
  int64_t all = 0;
  for (size_t i = 1; mesh.device && i < mesh.device->cells.size(); ++i) {
    const CellLayout &layout = *mesh.device->cells[i];
    all += 2 * bytes(layout.cells.label, layout.samples.list) + bytes(layout.measured);
  }
  return all;
}

static int64_t rows_of(std::span<const int> descriptors) {
  int64_t rows = ROW_DESCRIPTORS;
  for (const int descriptor : descriptors) rows += descriptor_row(descriptor).components;
  return rows;
}

static bool reads_map(std::span<const int> descriptors) {
  return std::ranges::any_of(descriptors, [](int row) { return descriptor_row(row).needs != MapNeeds::nothing; });
}

// Beside the mesh, for normals and results: what every backend takes.
static int64_t bytes_of_any(const Mesh &mesh, std::span<const int> descriptors) {
  const int64_t triangles = mesh.triangles.triangle_count, points = mesh.half_edges.point_count;
  return 60 * triangles + 400 * points + 12 * rows_of(descriptors) * points;
}

static int64_t bytes_of_device(const Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors) {
  const int64_t triangles = mesh.triangles.triangle_count, borders = static_cast<int64_t>(mesh.charts.borders.size());
  const auto places = static_cast<int64_t>(mesh.charts.sites.size());
  const int64_t texels = int64_t{options.buffer_size} * options.buffer_size;
  const int64_t a_texel = (options.precision == PDESC_PRECISION_HALF && !mesh.maps.any() ? 32 : 48) + 8 + 8 +
                          8 // borders, cells, depth and owners of a layout
                          + (reads_map(descriptors) ? 16 : 0);
  const int64_t centers = options.evaluate == PDESC_EVALUATE_TEXEL ? 32768 : places;
  int64_t bytes = texels * a_texel + triangles * 48 + places * 32 + borders * 100 + centers * (200 + 4 * rows_of(descriptors));
  if (options.relocation == PDESC_RELOCATION_CONNECTED) bytes += std::min<int64_t>(texels * 5 / 4, most_points) * 32;
  if (reads_map(descriptors)) bytes += places * 32;
  if (options.relocation == PDESC_RELOCATION_PAPER) bytes += int64_t{16384} * MAX_VISITS * 64 + 16384 * 2048;
  if (options.relocation == PDESC_RELOCATION_AFFINE) bytes += int64_t{65536} * 2048;
  return bytes;
}

MemoryOfCompute memory_of_compute(const Mesh &mesh, int backend, const pdesc_options &options, std::span<const int> descriptors) {
  MemoryOfCompute memory;
  memory.mesh = bytes_of_mesh(mesh);
  memory.host = bytes_of_any(mesh, descriptors);
  if (backend == PDESC_BACKEND_REFERENCE) return memory;
  memory.device = bytes_of_device(mesh, options, descriptors);
  const int64_t triangles = mesh.triangles.triangle_count, borders = static_cast<int64_t>(mesh.charts.borders.size());
  const auto places = static_cast<int64_t>(mesh.charts.sites.size());
  memory.host += int64_t{options.buffer_size} * options.buffer_size * 32 + triangles * 100 + places * 160 + borders * 300;
  if (options.relocation == PDESC_RELOCATION_CONNECTED && options.evaluate == PDESC_EVALUATE_VERTEX)
    memory.host += triangles * (mesh.patches ? 20 : 45); // patches, and what floods over them keep of each point
  if (options.evaluate == PDESC_EVALUATE_TEXEL)
    memory.host += int64_t{options.texels} * options.texels * (60 + 16 * rows_of(descriptors));
  return memory;
}

int64_t total_of(const MemoryOfCompute &memory, int backend) {
  constexpr int64_t rasterizer = 45'000'000; // llvmpipe's lists of what to draw where
  return memory.mesh + memory.host + (backend == PDESC_BACKEND_SOFTWARE ? memory.device + rasterizer : 0);
}

int64_t allowed_memory(const Context &context, int64_t held) {
  if (context.memory_limit > 0) return std::max<int64_t>(0, context.memory_limit - held);
  const int64_t free = free_memory();
  return free < 0 ? std::numeric_limits<int64_t>::max() : free / 2;
}

static std::string in_words(int64_t bytes) {
  const auto number = static_cast<double>(bytes);
  char text[32];
  if (bytes < 10'000'000)
    std::snprintf(text, sizeof text, "%.0f kB", std::ceil(1e-3 * number));
  else if (bytes < 1'000'000'000)
    std::snprintf(text, sizeof text, "%.0f MB", std::ceil(1e-6 * number));
  else
    std::snprintf(text, sizeof text, "%.1f GB", 1e-9 * number);
  return text;
}

void check_memory(const Context &context, const std::string &subject, const std::string &remedy, int64_t needed, int64_t held) {
  const int64_t allowed = allowed_memory(context, held);
  if (needed <= allowed) return;
  const bool limited = context.memory_limit > 0;
  throw Error(PDESC_ERROR_OUT_OF_MEMORY, subject + " needs about " + in_words(needed) + " of memory, and " + in_words(allowed) +
                                             " may be used (" +
                                             (limited ? "what the memory limit leaves" : "half of what is free") + "); " +
                                             remedy + ", or " + (limited ? "set a higher limit." : "close other programs."));
}

void check_memory_of_input(const Context &context, const pdesc_mesh_input &input) {
  check_memory(context,
               "A mesh of " + std::to_string(input.triangle_count) + " triangles and " + std::to_string(input.vertex_count) +
                   " vertices",
               "use fewer triangles", bytes_of_input(input), 0);
}

void check_memory_of_compute(const Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors) {
  const int backend = mesh.context->backend;
  const MemoryOfCompute memory = memory_of_compute(mesh, backend, options, descriptors);
  const bool reference = backend == PDESC_BACKEND_REFERENCE;
  check_memory(*mesh.context,
               "A computation on " + std::to_string(mesh.triangles.triangle_count) + " triangles" +
                   (reference ? std::string() : " with buffers of " + std::to_string(options.buffer_size) + " texels a side"),
               reference ? "use fewer triangles" : "use smaller buffers or fewer triangles",
               total_of(memory, backend) - memory.mesh, memory.mesh + bytes_of_other_cells(mesh));
}

} // namespace paradesc
