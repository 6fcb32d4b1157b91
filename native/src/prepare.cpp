// Mesh and options → everything that samples need: normals, centers, baked buffers, a layout, cells and neighborhoods.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/seam_links.h"
#include "mesh/cut.h"
#include "mesh/layout.h"
#include "sample/pattern.h"
#include "stages.h"
#include "support/cancel.h"
#include "support/error.h"

namespace paradesc {

Normals prepare_normals(Mesh &mesh, int32_t kind) {
  if (!mesh.rings) mesh.rings = build_normal_rings(mesh.triangles, mesh.half_edges, mesh.context->threads);
  return compute_normals(mesh.triangles, mesh.half_edges, *mesh.rings, kind, mesh.context->threads);
}

// Marches start a little inside the chart: from a vertex on its border every direction would begin on an edge.
static vec2 march_start(const Site &site, int size) {
  const vec2 way = site.inside - site.uv;
  const float texels = length(way) * static_cast<float>(size);
  return site.uv + way * std::min(0.2f, 0.02f / std::max(texels, 1e-6f));
}

static void prepare_centers(const Mesh &mesh, const pdesc_options &options, double radius, Frame &frame) {
  const std::vector<vec4> ellipses = sampling_ellipses(mesh.triangles, mesh.charts, frame.forms);
  const auto reach = static_cast<float>(radius * frame.buffer_frame.scale) * frame.enlargement;
  auto place_of = [&](size_t point) {
    if (frame.mapped) return frame.mapped->position[point];
    return frame.buffer_frame.to_buffer(mesh.triangles.positions[static_cast<size_t>(mesh.half_edges.point_vertex[point])]);
  };
  const std::vector<vec3> &normals = frame.mapped ? frame.mapped->normal : frame.normals.point;
  frame.centers.clear();
  frame.sites.clear();
  frame.points.clear();
  std::vector<double> sizes;
  for (size_t i = 0; i < mesh.charts.sites.size(); ++i) {
    if (i % 4096 == 0) checkpoint();
    const Site &site = mesh.charts.sites[i];
    const auto point = static_cast<size_t>(site.point);
    if (!options.seam_error && mesh.charts.point_site[point] != static_cast<int32_t>(i)) continue;
    const vec4 ellipse = ellipses[i] * reach;
    frame.centers.push_back({vec4(place_of(point), static_cast<float>(site.chart)),
                             vec4(normals[point], pattern_rotation(static_cast<uint32_t>(site.point), options.seed)),
                             vec4(site.uv, march_start(site, options.buffer_size)), ellipse});
    frame.sites.push_back(static_cast<int32_t>(i));
    frame.points.push_back(site.point);
    sizes.push_back(std::sqrt(std::max(0.0f, ellipse.x * ellipse.w - ellipse.y * ellipse.z)) *
                    static_cast<float>(options.buffer_size) / frame.enlargement);
  }
  // What the UV map leaves out counts as well: cells lead there, samples carried by the map do not.
  for (size_t point = 0; options.relocation == PDESC_RELOCATION_CONNECTED && point < mesh.charts.point_site.size(); ++point) {
    if (mesh.charts.point_site[point] >= 0) continue;
    frame.centers.push_back({vec4(place_of(point), -1.0f), vec4(normals[point], 0.0f), vec4(0.0f), vec4(0.0f)});
    frame.sites.push_back(-1);
    frame.points.push_back(static_cast<int32_t>(point));
  }
  if (sizes.empty()) return;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2), sizes.end());
  frame.radius_in_texels = sizes[sizes.size() / 2];
}

// Maps are applied to buffers of full precision.
static bool uses_half(const Mesh &mesh, const pdesc_options &options) {
  return options.precision == PDESC_PRECISION_HALF && !mesh.maps.any();
}

// Makes or keeps the device's buffers; true where the topology's part has to be uploaded.
static bool prepare_device(Mesh &mesh, const pdesc_options &options) {
  if (!mesh.device) mesh.device = std::make_unique<DeviceMesh>();
  DeviceMesh &device = *mesh.device;
  bool changed = device.buffer && device.buffer->half() != uses_half(mesh, options);
  if (device.grid.size != options.buffer_size) {
    device.normals_kind = -1; // until bake() has brought it to the device: a run may be cancelled before
    device.grid = build_border_grid(mesh.triangles, mesh.charts, options.buffer_size);
    changed = true;
  }
  // Corners of one fan share a normal, unless the mesh brings its own.
  const bool own = options.normals == PDESC_NORMALS_MESH;
  if (changed || (device.normals_kind == PDESC_NORMALS_MESH) != own || device.normals_kind < 0) {
    device.vertices = build_bake_vertices(mesh.triangles, mesh.charts, own ? std::vector<int32_t>() : mesh.rings->corner_fan);
    changed = true;
  }
  if (changed) device.normals_kind = -1;
  return changed;
}

static int count_bare_triangles(const Mesh &mesh, const std::vector<int32_t> &ids) {
  std::vector<uint8_t> seen(static_cast<size_t>(mesh.triangles.triangle_count), 0);
  for (size_t i = 0; i < ids.size(); i += 2)
    if (ids[i] >= 0 && ids[i + 1] >= 0) seen[static_cast<size_t>(ids[i + 1])] = 1;
  int bare = 0;
  for (size_t i = 0; i < seen.size(); ++i) bare += mesh.charts.triangle_chart[i] >= 0 && !seen[i];
  return bare;
}

// In steps on the device, between which a run may be cancelled; what is half done then is done again by the next run.
static void bake(Mesh &mesh, const pdesc_options &options, const Frame &frame, bool changed) {
  constexpr int drawn_at_once = 1 << 17; // triangles
  DeviceMesh &device = *mesh.device;
  const auto step = [&](const std::function<void(const Gl &, ProgramCache &)> &work) {
    checkpoint();
    mesh.context->gl->run(work);
  };
  const BakeInput input{mesh.triangles, mesh.charts, device.vertices, frame.normals, frame.forms, frame.buffer_frame};
  device.normals_kind = -1;
  step([&](const Gl &gl, ProgramCache &) {
    if (changed) {
      const bool half = uses_half(mesh, options);
      if (!device.buffer || device.buffer->size() != options.buffer_size || device.buffer->half() != half)
        device.buffer = std::make_unique<GeometryBuffer>(gl, options.buffer_size, half);
      device.evaluator.set_borders(gl, device.grid);
      device.buffer->upload_topology(input);
    }
  });
  step([&](const Gl &, ProgramCache &) {
    device.buffer->upload(input);
    device.buffer->clear();
  });
  const int count = device.buffer->triangle_count();
  for (int first = 0; first < count; first += drawn_at_once)
    step([&](const Gl &gl, ProgramCache &programs) {
      device.buffer->draw(programs, first, std::min(first + drawn_at_once, count));
      gl.Finish();
    });
  step([&](const Gl &gl, ProgramCache &programs) {
    device.buffer->draw_borders(programs);
    if (frame.mapped) device.mapper.run(gl, programs, *device.buffer, input, mesh.maps);
    device.frame = frame.buffer_frame;
  });
  if (changed) {
    step([&](const Gl &, ProgramCache &programs) { device.counts = device.buffer->count_owners(programs); });
    step([&](const Gl &, ProgramCache &) { device.bare_triangles = count_bare_triangles(mesh, device.buffer->read_ids()); });
    device.cells.block_size = 0;
  }
  device.normals_kind = options.normals;
}

// About half the radius: a support then meets a few dozen cells, at every radius.
static int block_size(double radius_in_texels, int buffer_size) {
  int size = 4;
  while (size * 4 <= radius_in_texels && size * 2 <= buffer_size) size *= 2;
  return size;
}

void build_cells_for(Mesh &mesh, const Frame &frame) {
  DeviceMesh &device = *mesh.device;
  const int size = block_size(frame.radius_in_texels, device.buffer->size());
  if (device.cells.block_size == size) return;
  std::vector<int32_t> ids;
  mesh.context->gl->run([&](const Gl &, ProgramCache &) { ids = device.buffer->read_ids(); });
  device.cells = build_cells(ids, device.grid, mesh.triangles, mesh.half_edges, mesh.charts, size, mesh.context->threads);
  mesh.context->gl->run(
      [&](const Gl &gl, ProgramCache &) { device.evaluator.set_cells(gl, device.cells, device.buffer->size()); });
}

// The triangles as they are measured: displaced where maps say so.
const Triangles &surface_of(const Mesh &mesh, const Frame &frame) {
  return frame.mapped ? frame.mapped->triangles : mesh.triangles;
}

// What the search for neighborhoods reads: the positions of this frame.
std::vector<vec4> measure_cells(Mesh &mesh) {
  std::vector<vec4> positions;
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &programs) {
    mesh.device->evaluator.measure_cells(gl, programs, *mesh.device->buffer);
    positions = mesh.device->buffer->read_position();
  });
  return positions;
}

// The neighborhoods of all centers, before any sample is drawn.
void search_supports(Mesh &mesh, double radius, Frame &frame, const std::vector<vec4> &positions,
                     const std::vector<SupportCenter> &centers) {
  DeviceMesh &device = *mesh.device;
  const auto reach = static_cast<float>(radius * frame.buffer_frame.scale);
  checkpoint();
  const MappedSurface surface(mesh.maps, mesh.triangles, frame.normals, frame.buffer_frame);
  const Supports supports =
      find_supports(device.cells, positions, surface_of(mesh, frame), frame.buffer_frame, centers, reach, mesh.context->threads);
  checkpoint();
  frame.bare = sample_bare_triangles(device.cells, mesh.triangles, frame.normals, frame.buffer_frame, reach,
                                     frame.mapped ? &surface : nullptr);
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { device.evaluator.set_supports(gl, supports, frame.bare); });
}

void prepare_supports(Mesh &mesh, const pdesc_options &options, double radius, Frame &frame) {
  // A vertex starts from all its places in the UV map; for seam errors each place has to find the others by itself.
  std::vector<int32_t> order(mesh.charts.sites.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int32_t a, int32_t b) {
    return mesh.charts.sites[static_cast<size_t>(a)].point < mesh.charts.sites[static_cast<size_t>(b)].point;
  });
  std::vector<int32_t> begin(static_cast<size_t>(mesh.half_edges.point_count) + 1, 0);
  for (const Site &site : mesh.charts.sites) ++begin[static_cast<size_t>(site.point) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<SupportCenter> centers;
  for (size_t i = 0; i < frame.centers.size(); ++i) {
    const auto point = static_cast<size_t>(frame.points[i]);
    const bool alone = options.seam_error && frame.sites[i] >= 0;
    const auto first = static_cast<size_t>(begin[point]), last = static_cast<size_t>(begin[point + 1]);
    const std::span<const int32_t> sites =
        alone ? std::span(frame.sites).subspan(i, 1) : std::span(order).subspan(first, last - first);
    const int32_t half_edge = mesh.half_edges.point_half_edge[point];
    centers.push_back({vec3(frame.centers[i].position_chart), sites,
                       frame.sites[i] < 0 ? mesh.device->cells.triangle_cell[static_cast<size_t>(half_edge / 3)] : -1});
  }
  search_supports(mesh, radius, frame, measure_cells(mesh), centers);
}

void prepare_and_bake(Mesh &mesh, const pdesc_options &options, double radius, Frame &frame) {
  const bool changed = prepare_device(mesh, options);
  frame.buffer_frame = frame_of(mesh.triangles, mesh.half_edges);
  frame.forms = first_fundamental_forms(mesh.triangles, mesh.charts, frame.buffer_frame, mesh.context->threads);
  if (options.relocation != PDESC_RELOCATION_CONNECTED) frame.links = seam_links(mesh.triangles, mesh.charts);
  if (options.relocation == PDESC_RELOCATION_PAPER) frame.seams = number_seams(mesh.charts);
  if (mesh.maps.any())
    frame.mapped =
        map_points(mesh.maps, mesh.triangles, mesh.half_edges, frame.normals, frame.buffer_frame, mesh.context->threads);
  if (frame.mapped) frame.enlargement = ellipse_enlargement * frame.mapped->shrinkage;
  checkpoint();
  prepare_centers(mesh, options, radius, frame);
  checkpoint();
  bake(mesh, options, frame, changed);
}

// What overlaps gets a layout of its own, charts that overlap themselves cut into pieces.
static bool part_overlaps(Mesh &mesh) {
  const Cuts cuts = cut_charts(mesh.triangles, mesh.half_edges, mesh.charts, mesh.context->threads);
  if (cuts.overlapping) {
    Charts charts = cuts.cut_charts > 0
                        ? build_charts(mesh.triangles, mesh.half_edges, cuts.triangle_piece, mesh.context->threads)
                        : mesh.charts;
    repack_charts(mesh.triangles, charts, 0.0, mesh.context->threads);
    mesh.charts = std::move(charts);
    mesh.cut_charts = cuts.cut_charts;
    mesh.private_layout = PDESC_LAYOUT_OVERLAPS;
  }
  mesh.overlap_free = true;
  return cuts.overlapping;
}

// Gives the mesh a layout of its own, which it keeps, where the UV map overlaps or leaves most of the buffers empty. The device's
// count of overlaps only raises the suspicion: rasterizers round, and small triangles of a sound map may share a texel too.
bool lay_out_afresh(Mesh &mesh, double radius_in_texels) {
  if (mesh.private_layout) return false;
  const TexelCounts &counts = mesh.device->counts;
  const double size = mesh.device->buffer->size();
  const bool sparse = counts.covered < 0.15 * size * size || radius_in_texels < 4.0;
  if (!mesh.overlap_free && (counts.overlapping > 0 || sparse) && part_overlaps(mesh)) return true;
  if (!sparse || mesh.fill_tried) return false; // it helps at every size and radius, or at none
  const bool filled = repack_charts(mesh.triangles, mesh.charts, 1.5, mesh.context->threads);
  mesh.fill_tried = true;
  if (!filled) return false;
  mesh.private_layout = PDESC_LAYOUT_SPARSE;
  return true;
}

// Neighborhoods of another radius, from the same cells.
void widen_supports(Mesh &mesh, const pdesc_options &options, double reach, Frame &frame) {
  prepare_centers(mesh, options, reach, frame);
  if (options.relocation == PDESC_RELOCATION_CONNECTED) prepare_supports(mesh, options, reach, frame);
}

} // namespace paradesc
