// Mesh and options → everything that samples need: normals, centers, baked buffers, a layout, cells and neighborhoods.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/seam_links.h"
#include "engine/opengl/stages.h"
#include "memory.h"
#include "mesh/cut.h"
#include "mesh/layout.h"
#include "sample/pattern.h"
#include "support/cancel.h"
#include "support/error.h"

namespace paradesc {

Normals prepare_normals(Mesh &mesh, int32_t kind) {
  if (!mesh.rings) mesh.rings = build_normal_rings(mesh.triangles, mesh.half_edges, mesh.context->threads);
  return compute_normals(mesh.triangles, mesh.half_edges, *mesh.rings, kind, mesh.context->threads);
}

Frame &prepare_frame(Mesh &mesh, const pdesc_options &options) {
  if (!mesh.device) mesh.device = std::make_unique<DeviceMesh>();
  std::shared_ptr<Frame> &last = mesh.device->last;
  if (last && last->version == mesh.version && last->normals_kind == options.normals) return *last;
  auto frame = std::make_shared<Frame>();
  frame->version = mesh.version;
  frame->normals_kind = options.normals;
  frame->normals = prepare_normals(mesh, options.normals);
  last = std::move(frame);
  return *last;
}

// Marches start a little inside the chart: from a vertex on its border every direction would begin on an edge.
static vec2 march_start(const Site &site, int size) {
  const vec2 way = site.inside - site.uv;
  const float texels = length(way) * static_cast<float>(size);
  return site.uv + way * std::min(0.2f, 0.02f / std::max(texels, 1e-6f));
}

// The sites that are evaluated at.
static bool is_center(const Mesh &mesh, const pdesc_options &options, size_t site) {
  return options.seam_error || mesh.charts.point_site[mesh.charts.sites[site].point] == static_cast<int32_t>(site);
}

// Of the radius, in texels, over every so many of them; ellipses: of these, for radius 1.
static double median_radius(const Mesh &mesh, const pdesc_options &options, float radius, const std::vector<vec4> &ellipses,
                            size_t step) {
  std::vector<double> sizes;
  for (size_t i = 0; i < ellipses.size(); ++i) {
    const vec4 ellipse = ellipses[i] * radius;
    if (is_center(mesh, options, i * step))
      sizes.push_back(std::sqrt(std::max(0.0f, ellipse.x * ellipse.w - ellipse.y * ellipse.z)) *
                      static_cast<float>(options.buffer_size));
  }
  if (sizes.empty()) return 0.0;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

std::vector<vec4> ellipses_of(Mesh &mesh, const Frame &frame, size_t step) {
  DeviceMesh &device = *mesh.device;
  if (device.sampled_step != step) {
    device.sampled_corners = corners_of_sites(mesh.charts, step);
    device.sampled_step = step;
  }
  return sampling_ellipses(mesh.triangles, mesh.charts, frame.buffer_frame, device.sampled_corners, step);
}

void prepare_centers(Mesh &mesh, const pdesc_options &options, double radius, Frame &frame) {
  // Samples that walk need all ellipses; the median of their sizes does with some.
  const bool connected = options.relocation == PDESC_RELOCATION_CONNECTED;
  const size_t step = connected ? std::max<size_t>(1, mesh.charts.sites.size() / 4096) : 1;
  const std::vector<vec4> ellipses = ellipses_of(mesh, frame, step);
  const auto own_radius = static_cast<float>(radius * frame.buffer_frame.scale);
  frame.radius_in_texels = median_radius(mesh, options, own_radius, ellipses, step);
  frame.centers.clear();
  frame.sites.clear();
  frame.points.clear();
  if (options.evaluate == PDESC_EVALUATE_TEXEL) return; // which has centers of its own
  auto place_of = [&](size_t point) {
    if (frame.mapped) return frame.mapped->position[point];
    return frame.buffer_frame.to_buffer(mesh.triangles.positions[mesh.half_edges.point_vertex[point]]);
  };
  const std::vector<vec3> &normals = frame.mapped ? frame.mapped->normal : frame.normals.point;
  frame.centers.reserve(mesh.charts.sites.size());
  frame.sites.reserve(mesh.charts.sites.size());
  frame.points.reserve(mesh.charts.sites.size());
  for (size_t i = 0; i < mesh.charts.sites.size(); ++i) {
    if (i % 4096 == 0) checkpoint();
    if (!is_center(mesh, options, i)) continue;
    const Site &site = mesh.charts.sites[i];
    const auto point = static_cast<size_t>(site.point);
    frame.centers.push_back({place_of(point), site.chart, normals[point],
                             pattern_rotation(static_cast<uint32_t>(site.point), options.seed),
                             vec4(site.uv, march_start(site, options.buffer_size)),
                             connected ? vec4(0.0f) : ellipses[i] * (own_radius * frame.enlargement)});
    frame.sites.push_back(static_cast<int32_t>(i));
    frame.points.push_back(site.point);
  }
  // What the UV map leaves out counts as well: cells lead there, samples carried by the map do not.
  for (size_t point = 0; connected && point < mesh.charts.point_site.size(); ++point) {
    if (mesh.charts.point_site[point] >= 0) continue;
    frame.centers.push_back({place_of(point), -1, normals[point], 0.0f, vec4(0.0f), vec4(0.0f)});
    frame.sites.push_back(-1);
    frame.points.push_back(static_cast<int32_t>(point));
  }
  frame.order.resize(frame.centers.size());
  std::iota(frame.order.begin(), frame.order.end(), 0);
}

// Maps are applied to buffers of full precision.
static bool uses_half(const Mesh &mesh, const pdesc_options &options) {
  return options.precision == PDESC_PRECISION_HALF && !mesh.maps.any();
}

// Makes or keeps the device's buffers; true where the topology's part has to be uploaded.
static bool prepare_device(Mesh &mesh, const pdesc_options &options) {
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
    device.vertices = build_bake_vertices(mesh.triangles, mesh.charts, own ? std::vector<int32_t>() : *mesh.rings->corner_fan);
    changed = true;
  }
  if (changed) device.normals_kind = -1;
  return changed;
}

static int count_bare_triangles(const Mesh &mesh, const std::vector<int32_t> &ids) {
  std::vector<uint8_t> seen(static_cast<size_t>(mesh.triangles.triangle_count), 0);
  for (size_t i = 0; i < ids.size(); i += 2)
    if (ids[i] >= 0 && ids[i + 1] >= 0) seen[ids[i + 1]] = 1;
  int bare = 0;
  for (size_t i = 0; i < seen.size(); ++i) bare += mesh.charts.triangle_chart[i] >= 0 && !seen[i];
  return bare;
}

// One step on the device; between them a run may be cancelled, and what is half done then is done again by the next run.
static void step(Mesh &mesh, const std::function<void(const Gl &, ProgramCache &)> &work) {
  checkpoint();
  mesh.context->gl->run(work);
}

// Who owns each texel.
static void bake_layout(Mesh &mesh, const pdesc_options &options, const BakeInput &input) {
  constexpr int drawn_at_once = 1 << 17; // triangles
  DeviceMesh &device = *mesh.device;
  step(mesh, [&](const Gl &gl, ProgramCache &) {
    const bool half = uses_half(mesh, options);
    device.cells.clear();
    if (!device.buffer || device.buffer->size() != options.buffer_size || device.buffer->half() != half)
      device.buffer = std::make_unique<GeometryBuffer>(gl, options.buffer_size, half);
    device.evaluator.set_borders(gl, device.grid);
    device.buffer->begin_layout(input);
  });
  const int count = device.buffer->triangle_count();
  for (int first = 0; first < count; first += drawn_at_once)
    step(mesh, [&](const Gl &gl, ProgramCache &programs) {
      device.buffer->draw_triangles(programs, first, std::min(first + drawn_at_once, count));
      gl.Flush(); // the device draws these while the next are on their way
    });
  step(mesh, [&](const Gl &, ProgramCache &programs) { device.buffer->draw_borders(programs); });
  step(mesh, [&](const Gl &, ProgramCache &programs) { device.counts = device.buffer->end_layout(programs); });
  step(mesh, [&](const Gl &, ProgramCache &) { device.bare_triangles = count_bare_triangles(mesh, device.buffer->read_ids()); });
  device.sampled_step = 0;
  device.texels = {};
}

// What is where in the layout.
static void bake_surface(Mesh &mesh, const Frame &frame, const BakeInput &input) {
  constexpr int drawn_at_once = 1 << 20; // texels
  DeviceMesh &device = *mesh.device;
  const int size = device.buffer->size(), rows = std::max(1, drawn_at_once / size);
  step(mesh, [&](const Gl &, ProgramCache &) { device.buffer->upload(input); });
  for (int first = 0; first < size; first += rows)
    step(mesh, [&](const Gl &gl, ProgramCache &programs) {
      device.buffer->draw_surface(programs, first, std::min(first + rows, size));
      gl.Flush();
    });
  step(mesh, [&](const Gl &gl, ProgramCache &programs) {
    if (frame.mapped) device.mapper.run(gl, programs, *device.buffer, input, mesh.maps);
    device.frame = frame.buffer_frame;
  });
}

static void bake(Mesh &mesh, const pdesc_options &options, const Frame &frame, bool changed) {
  DeviceMesh &device = *mesh.device;
  const BakeInput input{mesh.triangles, mesh.charts, device.vertices, frame.normals, frame.buffer_frame, mesh.context->threads};
  device.normals_kind = -1;
  for (const auto &layout : device.cells) {
    layout->measured.clear();
    layout->link_points.clear();
    layout->buffers->forget_points();
  }
  if (changed) bake_layout(mesh, options, input);
  bake_surface(mesh, frame, input);
  device.normals_kind = options.normals;
}

// About half the radius: a support then meets a few dozen cells, at every radius; more where samples lie farther apart than that.
// One invocation measures a cell, and software devices limit its loops (shared.h).
static int block_size(double radius_in_texels, int samples, int buffer_size) {
  constexpr int largest = 128;
  static_assert(largest * (largest + 1) < MAX_ITERATIONS);
  const double apart = radius_in_texels * std::sqrt(pi / samples), least = std::max(radius_in_texels / 3.0, 1.5 * apart);
  int size = 4;
  while (size <= least && size * 2 <= std::min(buffer_size, largest)) size *= 2;
  return size;
}

void build_cells_for(Mesh &mesh, const pdesc_options &options, Frame &frame) {
  DeviceMesh &device = *mesh.device;
  const int size = block_size(frame.radius_in_texels, options.samples, device.buffer->size());
  auto &kept = device.cells;
  const auto found = std::ranges::find_if(kept, [&](const auto &layout) { return layout->cells.block_size == size; });
  if (found != kept.end()) {
    if (found != kept.begin()) (*found)->buffers->forget_points();
    std::rotate(kept.begin(), found, found + 1);
    return;
  }
  // Several radii of an animation take turns; large buffers have lists of cells as large.
  const size_t most = device.buffer->size() <= 1024 ? 3 : 1;
  auto layout = std::make_unique<CellLayout>();
  std::vector<int32_t> ids;
  mesh.context->gl->run([&](const Gl &, ProgramCache &) {
    ids = device.buffer->read_ids();
    if (kept.size() >= most) kept.resize(most - 1);
  });
  layout->cells = build_cells(ids, device.grid, mesh.triangles, mesh.half_edges, mesh.charts, size, mesh.context->threads);
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) {
    layout->buffers = std::make_unique<CellBuffers>(gl, layout->cells, device.buffer->size());
    kept.insert(kept.begin(), std::move(layout));
  });
}

// The triangles as they are measured: displaced where maps say so.
const Triangles &surface_of(const Mesh &mesh, const Frame &frame) {
  return frame.mapped ? frame.mapped->triangles : mesh.triangles;
}

// The neighborhoods of centers, before any sample is drawn.
Supports search_supports(Mesh &mesh, const pdesc_options &options, double radius, int samples, Frame &frame,
                         const std::vector<SupportCenter> &centers) {
  DeviceMesh &device = *mesh.device;
  const int threads = mesh.context->threads, size = device.buffer->size();
  const auto reach = static_cast<float>(radius * frame.buffer_frame.scale);
  checkpoint();
  auto on_device = [&](const auto &body) { mesh.context->gl->run(body); };
  CellLayout &layout = *device.cells.front();
  if (layout.measured.empty())
    on_device(
        [&](const Gl &gl, ProgramCache &programs) { layout.measured = layout.buffers->measure(gl, programs, *device.buffer); });
  CellStrides strides = choose_strides(layout.cells, layout.measured, size, reach, samples, options.seed, threads);
  if (strides != layout.samples.strides) {
    layout.samples = {};
    CellSamples listed = list_samples(layout.cells, std::move(strides), size, threads);
    on_device([&](const Gl &gl, ProgramCache &) { layout.buffers->set_samples(gl, listed); });
    layout.samples = std::move(listed);
  }
  const MappedSurface surface(mesh.maps, mesh.triangles, frame.normals, frame.buffer_frame);
  frame.bare = sample_bare_triangles(layout.cells, mesh.triangles, frame.normals, frame.buffer_frame, reach,
                                     frame.mapped ? &surface : nullptr);
  auto link_points = [&]() -> const std::vector<vec3> & {
    if (layout.link_points.empty())
      on_device([&](const Gl &gl, ProgramCache &programs) {
        layout.link_points = read_points(gl, programs, *device.buffer, layout.cells.link_texel);
      });
    return layout.link_points;
  };
  const SupportSpace space{layout.cells,       layout.samples, layout.measured,       frame.bare, surface_of(mesh, frame),
                           frame.buffer_frame, link_points,    options.adaptive > 0.0};
  // Ranges of samples three times: in parts, as one list, and on the device.
  const auto most = static_cast<size_t>(allowed_memory(*mesh.context, 0)) / (3 * sizeof(ivec2));
  return find_supports(space, centers, reach, threads, most);
}

void set_supports(Mesh &mesh, const Supports &supports, Frame &frame) {
  DeviceMesh &device = *mesh.device;
  const CellLayout &layout = *device.cells.front();
  // Listing a point costs a few fetches of it.
  constexpr size_t worth = 4;
  size_t fetches = 0;
  for (const ivec2 range : supports.range) fetches += static_cast<size_t>(range.y - range.x);
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &programs) {
    if (fetches > worth * layout.samples.list.size()) layout.buffers->list_points(gl, programs, *device.buffer, device.points);
  });
  checkpoint();
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { device.evaluator.set_supports(gl, supports, frame.bare); });
  checkpoint();
}

template <class Value> static void reorder(const std::vector<int32_t> &order, std::vector<Value> &values) {
  std::vector<Value> ordered;
  ordered.reserve(values.size());
  for (const int32_t i : order) ordered.push_back(values[i]);
  values.swap(ordered);
}

void prepare_supports(Mesh &mesh, const pdesc_options &options, double radius, int samples, Frame &frame) {
  // A vertex starts from all its places in the UV map; for seam errors each place has to find the others by itself.
  std::vector<int32_t> begin(static_cast<size_t>(mesh.half_edges.point_count) + 1, 0);
  for (const Site &site : mesh.charts.sites) ++begin[site.point + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int32_t> order(mesh.charts.sites.size()), next(begin.begin(), begin.end() - 1);
  for (size_t i = 0; i < order.size(); ++i) order[next[mesh.charts.sites[i].point]++] = static_cast<int32_t>(i);
  std::vector<SupportCenter> centers;
  centers.reserve(frame.centers.size());
  for (size_t i = 0; i < frame.centers.size(); ++i) {
    const auto point = static_cast<size_t>(frame.points[i]);
    const bool alone = options.seam_error && frame.sites[i] >= 0;
    const auto first = static_cast<size_t>(begin[point]), last = static_cast<size_t>(begin[point + 1]);
    const std::span<const int32_t> sites =
        alone ? std::span(frame.sites).subspan(i, 1) : std::span(order).subspan(first, last - first);
    const int32_t half_edge = mesh.half_edges.point_half_edge[point];
    centers.push_back({frame.centers[i].position, sites,
                       frame.sites[i] < 0 ? mesh.device->cells.front()->cells.triangle_cell[half_edge / 3] : -1});
  }
  Supports supports = search_supports(mesh, options, radius, samples, frame, centers);
  checkpoint();
  // Invocations side by side then have much the same samples, and as many.
  const std::vector<int32_t> neighbors = std::move(supports.order);
  reorder(neighbors, supports.center);
  reorder(neighbors, frame.centers);
  reorder(neighbors, frame.sites);
  reorder(neighbors, frame.points);
  reorder(neighbors, frame.order);
  reorder(neighbors, supports.plain);
  frame.plain = std::move(supports.plain);
  set_supports(mesh, supports, frame);
}

// Displacement and buffers of the frame.
static void bake_frame(Mesh &mesh, const pdesc_options &options, Frame &frame, bool changed) {
  frame.baked = false; // until it is done: a run may be cancelled before
  frame.buffer_frame = frame_of(mesh.box);
  if (mesh.maps.any())
    frame.mapped =
        map_points(mesh.maps, mesh.triangles, mesh.half_edges, frame.normals, frame.buffer_frame, mesh.context->threads);
  if (frame.mapped) frame.enlargement = ellipse_enlargement * frame.mapped->shrinkage;
  checkpoint();
  bake(mesh, options, frame, changed);
  frame.baked = true;
}

void prepare_and_bake(Mesh &mesh, const pdesc_options &options, double radius, Frame &frame) {
  const bool changed = prepare_device(mesh, options);
  if (changed || !frame.baked) bake_frame(mesh, options, frame, changed);
  if (options.relocation != PDESC_RELOCATION_CONNECTED) frame.links = seam_links(mesh.triangles, mesh.charts);
  if (options.relocation == PDESC_RELOCATION_PAPER) frame.seams = number_seams(mesh.charts);
  prepare_centers(mesh, options, radius, frame);
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

// Of all charts together; the square's is 1.
static double area_in_map(const Mesh &mesh) {
  double area = 0.0;
  for (size_t triangle = 0; triangle < mesh.charts.triangle_chart.size(); ++triangle) {
    if (mesh.charts.triangle_chart[triangle] < 0) continue;
    const vec2 *uv = &mesh.triangles.corner_uv[3 * triangle];
    area += 0.5 * std::abs(cross(dvec2(uv[1]) - dvec2(uv[0]), dvec2(uv[2]) - dvec2(uv[0])));
  }
  return area;
}

// More area than the square has lies on itself somewhere, and would take as many times longer to draw.
void part_crowded(Mesh &mesh) {
  constexpr double square = 1.001; // and what roundings add
  const bool drawn = mesh.device->grid.size != 0;
  if (!drawn && !mesh.private_layout && !mesh.overlap_free && area_in_map(mesh) > square) part_overlaps(mesh);
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

} // namespace paradesc
