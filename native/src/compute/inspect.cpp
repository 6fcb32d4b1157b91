// What can be read of a mesh between computes: its report, and the baked buffers (paper Fig. 1).
#include <cmath>
#include <limits>

#include "compute/compute.h"
#include "support/error.h"

namespace paradesc {

pdesc_mesh_report describe(const Mesh &mesh) {
  pdesc_mesh_report report{};
  report.vertex_count = mesh.triangles.vertex_count;
  report.triangle_count = mesh.triangles.triangle_count;
  report.loose_vertices = mesh.half_edges.loose_vertices;
  report.welded_vertices = mesh.half_edges.welded_vertices;
  report.degenerate_triangles = mesh.half_edges.degenerate_triangles;
  report.zero_uv_area_triangles = mesh.charts.zero_uv_area_triangles;
  report.flipped_triangles = mesh.charts.flipped_triangles;
  report.nonmanifold_edges = mesh.half_edges.nonmanifold_edges;
  report.nonmanifold_vertices = mesh.half_edges.nonmanifold_vertices;
  report.boundary_edges = mesh.half_edges.boundary_edges;
  report.charts = mesh.charts.chart_count;
  report.seam_edges = mesh.charts.seam_edges;
  report.self_seam_edges = mesh.charts.self_seam_edges;
  report.unlinked_edges = mesh.charts.unlinked_edges;
  report.parts = mesh.half_edges.parts;
  report.uv_remapped = mesh.triangles.uv_remapped;
  return report;
}

pdesc_mesh_report report_of(const Mesh &mesh) {
  pdesc_mesh_report report = mesh.found;
  report.diagonal = static_cast<float>(mesh.diagonal);
  report.mean_edge = static_cast<float>(mesh.mean_edge);
  return report;
}

static constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// Positions and normals; nothing where no chart is.
static ReadBuffer vectors(const std::vector<vec4> &texels, const std::vector<int32_t> &ids, dvec3 center, double scale) {
  ReadBuffer read{0, 3, {}};
  for (size_t i = 0; i < texels.size(); ++i)
    for (int k = 0; k < 3; ++k)
      read.values.push_back(ids[2 * i] < 0 ? nan : static_cast<float>(static_cast<double>(texels[i][k]) / scale + center[k]));
  return read;
}

// sigma_u, sigma_v in units of the positions per u or v, theta_e, area element.
static ReadBuffer distortions(const std::vector<vec4> &texels, const std::vector<int32_t> &ids, float scale) {
  ReadBuffer read{0, 4, {}};
  for (size_t i = 0; i < texels.size(); ++i) {
    const vec4 value = texels[i] / vec4(scale, scale, 1.0f, scale * scale);
    for (int k = 0; k < 4; ++k) read.values.push_back(ids[2 * i] < 0 ? nan : value[k]);
  }
  return read;
}

static ReadBuffer chart_numbers(const std::vector<int32_t> &ids) {
  ReadBuffer read;
  for (size_t i = 0; i < ids.size(); i += 2) read.values.push_back(static_cast<float>(ids[i]));
  return read;
}

// The chart beyond the first seam of the texel's own chart that runs through it.
static ReadBuffer neighbor_charts(const std::vector<int32_t> &ids, const BorderGrid &grid, const Charts &charts) {
  ReadBuffer read;
  for (size_t i = 0; i < ids.size() / 2; ++i) {
    float found = -1.0f;
    const int32_t edges = -std::min(grid.cells[2 * i], 0), first = grid.cells[2 * i + 1];
    for (int32_t k = first; found < 0.0f && k < first + edges; ++k) {
      const Border &border = charts.borders[grid.list[2 * static_cast<size_t>(k)]];
      if (border.chart == ids[2 * i] && border.kind == BorderKind::seam && border.twin >= 0)
        found = static_cast<float>(charts.borders[border.twin].chart);
    }
    read.values.push_back(found);
  }
  return read;
}

ReadBuffer read_buffer(Mesh &mesh, const std::string &name) {
  if (!mesh.device || !mesh.device->buffer || mesh.device->normals_kind < 0)
    throw Error(PDESC_ERROR_INVALID_OPERATION,
                "This mesh has no baked buffers; compute on a backend other than the reference first.");
  const DeviceMesh &device = *mesh.device;
  ReadBuffer read;
  mesh.gl->run([&](const Gl &, ProgramCache &programs) {
    const std::vector<int32_t> ids = device.buffer->read_ids();
    if (name == "position")
      read = vectors(device.buffer->read_position(), ids, device.frame.center, device.frame.scale);
    else if (name == "normal")
      read = vectors(device.buffer->read_normal(), ids, dvec3(0.0), 1.0);
    else if (name == "distortion")
      read = distortions(device.buffer->read_distortion(programs), ids, static_cast<float>(device.frame.scale));
    else if (name == "chart")
      read = chart_numbers(ids);
    else if (name == "neighbor")
      read = neighbor_charts(ids, device.grid, mesh.charts);
    else
      throw Error(PDESC_ERROR_INVALID_ARGUMENT,
                  "There is no buffer '" + name + "'; choose position, normal, chart, neighbor or distortion.");
  });
  read.size = device.buffer->size();
  return read;
}

} // namespace paradesc
