// Checks first, topology next; everything that depends on positions is measured again when they change.
#include "compute/mesh.h"

#include <string>

#include "compute/memory.h"
#include "mesh/steady_faces.h"
#include "mesh/winding.h"
#include "support/cancel.h"
#include "support/error.h"

namespace paradesc {

// Describes the mesh and its UV map as they were given.
static pdesc_mesh_report describe(const Triangles &triangles, const HalfEdges &half_edges, const Charts &charts) {
  pdesc_mesh_report report{};
  report.vertex_count = triangles.vertex_count;
  report.triangle_count = triangles.triangle_count;
  report.loose_vertices = half_edges.loose_vertices;
  report.welded_vertices = half_edges.welded_vertices;
  report.degenerate_triangles = half_edges.degenerate_triangles;
  report.zero_uv_area_triangles = charts.zero_uv_area_triangles;
  report.flipped_triangles = charts.flipped_triangles;
  report.nonmanifold_edges = half_edges.nonmanifold_edges;
  report.nonmanifold_vertices = half_edges.nonmanifold_vertices;
  report.boundary_edges = half_edges.boundary_edges;
  report.charts = charts.chart_count;
  report.seam_edges = charts.seam_edges;
  report.self_seam_edges = charts.self_seam_edges;
  report.unlinked_edges = charts.unlinked_edges;
  report.parts = half_edges.components;
  report.uv_remapped = triangles.uv_remapped;
  report.copied_triangles = half_edges.copied_triangles;
  report.opposed_edges = half_edges.opposed_edges;
  return report;
}

double mean_edge_of(const Mesh &mesh) {
  return mesh.mean_edge.get(mesh.positions_version,
                            [&] { return mean_edge(mesh.triangles, mesh.half_edges, mesh.context->threads); });
}

pdesc_mesh_report report_of(const Mesh &mesh) {
  pdesc_mesh_report report = mesh.found;
  report.diagonal = static_cast<float>(mesh.box.diagonal());
  report.mean_edge = static_cast<float>(mean_edge_of(mesh));
  report.inward_parts = count_inward_parts(mesh.triangles, mesh.half_edges, mesh.box, mesh.context->threads);
  return report;
}

void check_triangle_count(const Abilities &abilities, int32_t triangles) {
  if (triangles > abilities.max_triangles)
    throw Error(PDESC_ERROR_UNSUPPORTED, "The mesh has " + std::to_string(triangles) + " triangles, and graphics devices take " +
                                             std::to_string(abilities.max_triangles) + "; use fewer, or the backend cpu.");
}

std::unique_ptr<Mesh> make_mesh(std::shared_ptr<Context> context, const pdesc_mesh_input &input) {
  check_memory_of_input(*context, input);
  check_triangle_count(abilities_of(context->backend), input.triangle_count);
  const CancelScope cancel([&] { check_cancel(progress_of(input.progress, input.user), "mesh", 0.0); });
  auto mesh = std::make_unique<Mesh>();
  const int threads = context->threads;
  mesh->context = std::move(context);
  mesh->triangles = read_triangles(input);
  checkpoint();
  mesh->half_edges = build_half_edges(mesh->triangles, threads);
  mesh->atlases = Atlases(build_charts(mesh->triangles, mesh->half_edges, {}, threads));
  checkpoint();
  mesh->box = bounding_box(mesh->triangles, mesh->half_edges, threads);
  mesh->found = describe(mesh->triangles, mesh->half_edges, mesh->atlases.current().charts);
  return mesh;
}

void move_mesh(Mesh &mesh, const float *positions, int32_t vertex_count) {
  set_positions(mesh.triangles, positions, vertex_count);
  ++mesh.positions_version;
  mesh.box = bounding_box(mesh.triangles, mesh.half_edges, mesh.context->threads);
}

double requested_radius(const Mesh &mesh, const pdesc_options &options) {
  const double unit = options.radius_unit == PDESC_RADIUS_DIAGONAL    ? mesh.box.diagonal()
                      : options.radius_unit == PDESC_RADIUS_MEAN_EDGE ? mean_edge_of(mesh)
                                                                      : 1.0;
  return options.radius * unit;
}

// Reuses the previous frame's array: allocating a new one would cost as much as filling it.
static std::span<const vec3> steady_normals_of(Mesh &mesh) {
  if (mesh.steady_version != mesh.positions_version) {
    mesh.steady_normals.resize(static_cast<size_t>(mesh.triangles.triangle_count));
    round_steady_normals(mesh.triangles, mesh.half_edges, mesh.steady_normals, mesh.context->threads);
    mesh.steady_version = mesh.positions_version;
  }
  return mesh.steady_normals;
}

const Creases &creases_of(Mesh &mesh, const pdesc_options &options) {
  const int threads = mesh.context->threads;
  const int32_t kind = options.creases;
  const Creases &all = mesh.creases.get({mesh.positions_version, kind}, [&] {
    return kind == PDESC_CREASES_AUTO ? find_creases(mesh.triangles, mesh.half_edges, steady_normals_of(mesh), threads)
                                      : marked_creases(mesh.triangles, mesh.half_edges);
  });
  if (kind != PDESC_CREASES_AUTO) return all;
  const double radius = requested_radius(mesh, options);
  return mesh.counting_creases.get({mesh.positions_version, kind, radius}, [&] {
    return creases_that_count(mesh.triangles, mesh.half_edges, all, steady_normals_of(mesh), radius, threads);
  });
}

static const NormalRings &rings_of(Mesh &mesh, const Creases &creases) {
  if (!mesh.rings) mesh.rings = build_normal_rings(mesh.triangles, mesh.half_edges, creases, mesh.context->threads);
  return *mesh.rings;
}

// Rings pay off only from the second frame on, so a mesh that has never moved gets none.
static Normals make_normals(Mesh &mesh, const Creases &creases, int32_t kind) {
  const int threads = mesh.context->threads;
  const bool once = kind == PDESC_NORMALS_MESH || (mesh.positions_version == 0 && !mesh.rings);
  return once ? compute_normals_once(mesh.triangles, mesh.half_edges, creases, kind, threads)
              : compute_normals(mesh.triangles, mesh.half_edges, rings_of(mesh, creases), kind, threads);
}

NormalsOnDemand normals_of(Mesh &mesh, const pdesc_options &options) {
  const Creases &creases = creases_of(mesh, options);
  if (mesh.normals_end_at != creases.edges) {
    mesh.normals_end_at = creases.edges;
    ++mesh.rings_version;
    mesh.rings.reset();
  }
  const int32_t kind = options.normals;
  NormalsOnDemand normals;
  normals.key = {mesh.positions_version, static_cast<uint64_t>(kind), mesh.rings_version};
  normals.make = [&mesh, &creases, kind, key = normals.key]() -> const Normals & {
    return mesh.normals.get(key, [&] { return make_normals(mesh, creases, kind); });
  };
  return normals;
}

const Facets &facets_of(Mesh &mesh, const pdesc_options &options) {
  const NormalsOnDemand normals = normals_of(mesh, options);
  return mesh.facets.get(normals.key, [&] {
    return find_facets(mesh.triangles, mesh.half_edges, normals(), creases_of(mesh, options), mesh.context->threads);
  });
}

ReadBuffer read_buffer(Mesh &mesh, const std::string &name) {
  ReadBuffer read;
  if (mesh.session) read = mesh.session->read_buffer(name, mesh.atlases.current());
  if (read.size == 0)
    throw Error(PDESC_ERROR_INVALID_OPERATION,
                "This mesh has no baked buffers; compute in texture space first: with buffers = 1, "
                "on the backend auto, gpu or software.");
  return read;
}

int buffer_size(const Mesh &mesh) { return mesh.session ? mesh.session->buffer_size() : 0; }

} // namespace paradesc
