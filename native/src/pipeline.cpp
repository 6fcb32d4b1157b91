// The data path in reading order: prepare → bake → evaluate → gather. compute() is its table of contents.
#include "pipeline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "bake/distortion.h"
#include "bake/seam_links.h"
#include "descriptor/reference.h"
#include "descriptor/registry.h"
#include "descriptor_limits.h"
#include "image/passes.h"
#include "mesh/cut.h"
#include "mesh/layout.h"
#include "sample/pattern.h"
#include "sample/texels.h"
#include "support/error.h"
#include "support/parallel.h"

namespace paradesc {

// The sampling ellipse reaches beyond the ball: curvature leaves the rim of one that just touches it empty.
static constexpr float ellipse_enlargement = 1.25f;

std::shared_ptr<Context> make_context(const pdesc_context_options &options) {
  auto context = std::make_shared<Context>();
  context->threads = options.threads;
  const bool automatic = options.backend == PDESC_BACKEND_AUTO;
  for (const int backend : {PDESC_BACKEND_GPU, PDESC_BACKEND_SOFTWARE}) {
    if (!automatic && options.backend != backend) continue;
    try {
      context->gl = std::make_unique<GlThread>(backend == PDESC_BACKEND_SOFTWARE, options.device_index);
      context->backend = backend;
      context->device = context->gl->device();
      return context;
    } catch (const Error &error) {
      if (!automatic) throw;
      context->fallback = error.what();
    }
  }
  context->backend = PDESC_BACKEND_REFERENCE;
  context->device = "CPU, " + std::to_string(thread_count(options.threads)) + " threads (object-space reference)";
  return context;
}

static void measure(Mesh &mesh) {
  const Box box = bounding_box(mesh.triangles, mesh.half_edges);
  mesh.diagonal = length(box.high - box.low);
  double sum = 0.0;
  int count = 0;
  for (int h = 0; h < 3 * mesh.triangles.triangle_count; ++h) {
    // Each edge once: a pair by its lower half-edge.
    const int32_t twin = mesh.half_edges.twin[static_cast<size_t>(h)];
    if (mesh.half_edges.corner_point[static_cast<size_t>(h)] < 0 || (twin >= 0 && twin < h)) continue;
    auto at = [&](int c) {
      return dvec3(mesh.triangles.positions[static_cast<size_t>(mesh.triangles.corner_vertex[static_cast<size_t>(c)])]);
    };
    sum += length(at(next_corner(h)) - at(h));
    ++count;
  }
  mesh.mean_edge = count ? sum / count : 0.0;
}

std::unique_ptr<Mesh> make_mesh(std::shared_ptr<Context> context, const pdesc_mesh_input &input) {
  auto mesh = std::make_unique<Mesh>();
  mesh->context = std::move(context);
  mesh->triangles = read_triangles(input);
  mesh->half_edges = build_half_edges(mesh->triangles);
  mesh->charts = build_charts(mesh->triangles, mesh->half_edges);
  measure(*mesh);
  mesh->found = describe(*mesh);
  return mesh;
}

Mesh::~Mesh() {
  if (device && context->gl) context->gl->run([&](const Gl &, ProgramCache &) { device.reset(); });
}

void move_mesh(Mesh &mesh, const float *positions, int32_t vertex_count) {
  set_positions(mesh.triangles, positions, vertex_count);
  measure(mesh);
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

static void check_cancel(const Progress &progress, const char *stage, double fraction) {
  if (!progress(stage, fraction)) throw Error(PDESC_ERROR_CANCELLED, std::string("Cancelled in stage ") + stage + ".");
}

namespace {

// Everything of one frame that is made on the CPU before the device is asked.
struct Frame {
  Normals normals;
  BufferFrame buffer_frame;
  std::vector<vec4> forms, links;
  std::vector<int32_t> seams; // (borders) what seam each belongs to, where the paper's relocation asks
  std::vector<CenterData> centers;
  std::vector<int32_t> sites;  // (centers) -1: the point has no place in the UV map
  std::vector<int32_t> points; // (centers)
  BareSamples bare;
  double radius_in_texels = 0.0;
  std::optional<MappedPoints> mapped; // where maps displace the surface
  float enlargement = ellipse_enlargement;
};

class Clock {
public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace

static Normals prepare_normals(Mesh &mesh, int32_t kind) {
  if (!mesh.rings) mesh.rings = build_normal_rings(mesh.triangles, mesh.half_edges);
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
    device.grid = build_border_grid(mesh.triangles, mesh.charts, options.buffer_size);
    changed = true;
  }
  // Corners of one fan share a normal, unless the mesh brings its own.
  const bool own = options.normals == PDESC_NORMALS_MESH;
  if (changed || (device.normals_kind == PDESC_NORMALS_MESH) != own || device.normals_kind < 0) {
    device.vertices = build_bake_vertices(mesh.triangles, mesh.charts, own ? std::vector<int32_t>() : mesh.rings->corner_fan);
    changed = true;
  }
  if (changed) device.normals_kind = -1; // until bake() has brought it to the device: a run may be cancelled before
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

static void bake(Mesh &mesh, const pdesc_options &options, const Frame &frame, bool changed) {
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &programs) {
    DeviceMesh &device = *mesh.device;
    if (changed) {
      const bool half = uses_half(mesh, options);
      if (!device.buffer || device.buffer->size() != options.buffer_size || device.buffer->half() != half)
        device.buffer = std::make_unique<GeometryBuffer>(gl, options.buffer_size, half);
      device.evaluator.set_borders(gl, device.grid);
    }
    const BakeInput input{mesh.triangles, mesh.charts, device.vertices, frame.normals, frame.forms, frame.buffer_frame};
    device.buffer->bake(programs, input, changed);
    if (frame.mapped) device.mapper.run(gl, programs, *device.buffer, input, mesh.maps);
    device.frame = frame.buffer_frame;
    if (!changed) return;
    device.counts = device.buffer->count_owners(programs);
    device.bare_triangles = count_bare_triangles(mesh, device.buffer->read_ids());
    device.cells.block_size = 0;
    device.normals_kind = options.normals;
  });
}

// About half the radius: a support then meets a few dozen cells, at every radius.
static int block_size(double radius_in_texels, int buffer_size) {
  int size = 4;
  while (size * 4 <= radius_in_texels && size * 2 <= buffer_size) size *= 2;
  return size;
}

static void build_cells_for(Mesh &mesh, const Frame &frame) {
  DeviceMesh &device = *mesh.device;
  const int size = block_size(frame.radius_in_texels, device.buffer->size());
  if (device.cells.block_size == size) return;
  std::vector<int32_t> ids;
  mesh.context->gl->run([&](const Gl &, ProgramCache &) { ids = device.buffer->read_ids(); });
  device.cells = build_cells(ids, device.grid, mesh.triangles, mesh.half_edges, mesh.charts, size);
  mesh.context->gl->run(
      [&](const Gl &gl, ProgramCache &) { device.evaluator.set_cells(gl, device.cells, device.buffer->size()); });
}

// The triangles as they are measured: displaced where maps say so.
static const Triangles &surface_of(const Mesh &mesh, const Frame &frame) {
  return frame.mapped ? frame.mapped->triangles : mesh.triangles;
}

// What the search for neighborhoods reads: the positions of this frame.
static std::vector<vec4> measure_cells(Mesh &mesh) {
  std::vector<vec4> positions;
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &programs) {
    mesh.device->evaluator.measure_cells(gl, programs, *mesh.device->buffer);
    positions = mesh.device->buffer->read_position();
  });
  return positions;
}

// The neighborhoods of all centers, before any sample is drawn.
static void search_supports(Mesh &mesh, double radius, Frame &frame, const std::vector<vec4> &positions,
                            const std::vector<SupportCenter> &centers) {
  DeviceMesh &device = *mesh.device;
  const auto reach = static_cast<float>(radius * frame.buffer_frame.scale);
  const MappedSurface surface(mesh.maps, mesh.triangles, frame.normals, frame.buffer_frame);
  const Supports supports =
      find_supports(device.cells, positions, surface_of(mesh, frame), frame.buffer_frame, centers, reach, mesh.context->threads);
  frame.bare = sample_bare_triangles(device.cells, mesh.triangles, frame.normals, frame.buffer_frame, reach,
                                     frame.mapped ? &surface : nullptr);
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { device.evaluator.set_supports(gl, supports, frame.bare); });
}

static void prepare_supports(Mesh &mesh, const pdesc_options &options, double radius, Frame &frame) {
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

// Samples that walk in one dispatch. llvmpipe ends the loops of an invocation after 65535 iterations (shared.h), and the eight
// invocations of its vector count together.
static int samples_at_once(const Mesh &mesh, const pdesc_options &options) {
  if (mesh.context->backend != PDESC_BACKEND_SOFTWARE) return options.samples;
  const int samples = options.relocation == PDESC_RELOCATION_PAPER ? 8 : 64; // each of them up to MAX_VISITS times
  return options.geodesic == PDESC_GEODESIC_CHORDS ? samples / 8 : samples;
}

// The map goes where samples find it: texels, centers, and triangles without texels.
static void bake_map(Mesh &mesh, const Frame &frame, const MapValues &values) {
  DeviceMesh &device = *mesh.device;
  std::vector<vec4> centers, bare;
  for (const int32_t point : frame.points) centers.push_back(values[static_cast<size_t>(point)]);
  for (size_t i = 0; i < frame.bare.weights.size(); ++i) {
    const auto triangle = static_cast<size_t>(frame.bare.point[2 * i + 1].w);
    auto corner = [&](size_t k) { return values[static_cast<size_t>(mesh.half_edges.corner_point[3 * triangle + k])]; };
    const vec2 weights = frame.bare.weights[i];
    bare.push_back(corner(0) * (1.0f - weights.x - weights.y) + corner(1) * weights.x + corner(2) * weights.y);
  }
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &programs) {
    if (!device.map || device.map->size() != device.buffer->size())
      device.map = std::make_unique<MapBuffer>(gl, device.buffer->size());
    device.map->bake(programs, {mesh.triangles, mesh.half_edges, mesh.charts, device.vertices, values});
    device.evaluator.set_map(gl, centers, bare);
  });
}

// Tiles of about 30 ms keep the callback's latency, and a desktop driver's patience, well within bounds.
static void evaluate_tiles(Mesh &mesh, const EvaluateSettings &settings, int count, const Progress &progress, double from,
                           double to) {
  constexpr int smallest_tile = 8 * GROUP_SIZE; // enough for every core of a software device
  int tile = smallest_tile;
  for (int first = 0; first < count;) {
    const int last = first + std::min({tile, count - first, settings.largest_tile()});
    Clock clock;
    mesh.context->gl->run([&](const Gl &gl, ProgramCache &programs) {
      mesh.device->evaluator.run(gl, programs, *mesh.device->buffer, settings, first, last);
    });
    const double scale = std::clamp(0.03 / std::max(clock.lap(), 1e-4), 0.25, 4.0);
    tile = std::max(smallest_tile, static_cast<int>(tile * scale) / GROUP_SIZE * GROUP_SIZE);
    first = last;
    check_cancel(progress, "evaluate", from + (to - from) * first / count);
  }
}

// Centers whose neighborhood is no disk, and has another area than the triangles that the surface reaches within the ball: once
// more, on exactly those triangles.
static void evaluate_folded(Mesh &mesh, EvaluateSettings settings, double radius, const Frame &frame, const Progress &progress) {
  constexpr double same_area = 0.06; // of a disk; samples of a folded place miss its area by some per cent
  std::vector<float> raw;
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { raw = mesh.device->evaluator.read(gl, settings); });
  std::vector<int32_t> centers, points;
  const size_t count = frame.centers.size();
  for (size_t i = 0; i < count; ++i) {
    if (raw[ROW_FLAGS * count + i] < FLAG_NO_DISK) continue;
    centers.push_back(static_cast<int32_t>(i));
    points.push_back(frame.points[i]);
  }
  Reach reach = reach_exactly(surface_of(mesh, frame), mesh.half_edges, points, radius, MAX_REACH, mesh.context->threads);
  std::vector<int32_t> triangles;
  size_t kept = 0;
  const double disk = pi * radius * radius, unit = frame.buffer_frame.scale * frame.buffer_frame.scale;
  for (size_t i = 0; i < centers.size(); ++i) {
    const int32_t begin = reach.begin[i], end = reach.begin[i + 1]; // none where there were too many
    const double found = static_cast<double>(raw[ROW_AREA * count + static_cast<size_t>(centers[i])]) / unit;
    if (begin == end || std::abs(found - reach.area[i]) < same_area * disk) continue;
    centers[kept] = centers[i];
    reach.begin[kept++] = static_cast<int32_t>(triangles.size());
    triangles.insert(triangles.end(), reach.triangle.begin() + begin, reach.triangle.begin() + end);
  }
  if (kept == 0) return;
  reach.begin[kept] = static_cast<int32_t>(triangles.size());
  reach.triangle = std::move(triangles);
  centers.resize(kept);
  reach.begin.resize(kept + 1);
  settings.exact = true;
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { mesh.device->evaluator.set_reach(gl, centers, reach); });
  evaluate_tiles(mesh, settings, static_cast<int>(kept), progress, 0.8, 1.0);
}

// All centers of the frame, from one fraction of the whole to another.
static void evaluate(Mesh &mesh, const EvaluateSettings &settings, const Frame &frame, const Progress &progress, double from,
                     double to) {
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) {
    mesh.device->evaluator.set_links(gl, frame.links, frame.seams);
    mesh.device->evaluator.set_centers(gl, frame.centers, settings);
  });
  evaluate_tiles(mesh, settings, static_cast<int>(frame.centers.size()), progress, from, to);
}

static SiteResults read_results(Mesh &mesh, const EvaluateSettings &settings, const Frame &frame) {
  std::vector<float> raw;
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { raw = mesh.device->evaluator.read(gl, settings); });
  const size_t count = frame.centers.size();
  SiteResults results;
  results.values.resize(settings.descriptors.size());
  size_t refined = 0;
  for (size_t i = 0; i < count; ++i) {
    results.coverage.push_back(raw[ROW_COVERAGE * count + i]);
    const float flags = raw[ROW_FLAGS * count + i];
    results.boundary.push_back(std::fmod(flags, FLAG_ALL_SAMPLES) >= FLAG_CUT);
    refined += std::fmod(flags, FLAG_NO_DISK) >= FLAG_ALL_SAMPLES;
  }
  results.refined_share = count ? static_cast<double>(refined) / static_cast<double>(count) : 1.0;
  size_t row = ROW_DESCRIPTORS;
  for (size_t k = 0; k < settings.descriptors.size(); ++k) {
    const DescriptorRow &descriptor = descriptor_row(settings.descriptors[k]);
    const auto unit = static_cast<float>(std::pow(frame.buffer_frame.scale, -descriptor.length_power));
    const auto width = static_cast<size_t>(descriptor.components);
    results.values[k].resize(count * width);
    for (size_t component = 0; component < width; ++component, ++row)
      for (size_t i = 0; i < count; ++i) results.values[k][i * width + component] = raw[row * count + i] * unit;
  }
  return results;
}

static SiteResults evaluate_vertices(Mesh &mesh, const EvaluateSettings &settings, double radius, const Frame &frame,
                                     const Progress &progress, Field &field) {
  evaluate(mesh, settings, frame, progress, 0.3, 0.8);
  if (settings.relocation == PDESC_RELOCATION_CONNECTED) evaluate_folded(mesh, settings, radius, frame, progress);
  SiteResults results = read_results(mesh, settings, frame);
  results.point = frame.points;
  for (size_t i = 0; i < frame.points.size(); ++i)
    results.primary.push_back(mesh.charts.point_site[static_cast<size_t>(frame.points[i])] == frame.sites[i]);
  field.report.places = static_cast<int32_t>(frame.centers.size());
  return results;
}

// The texels of a map, so many at a time that a run can be cancelled between; then the vertices from there.
static SiteResults evaluate_texels(Mesh &mesh, const pdesc_options &options, std::span<const int> asked,
                                   EvaluateSettings settings, Frame &frame, const Progress &progress, Field &field) {
  for (const int row : asked)
    if (descriptor_row(row).needs != MapNeeds::nothing)
      throw Error(PDESC_ERROR_INVALID_ARGUMENT, std::string("The operator ") + descriptor_row(row).name +
                                                    " works on a map of values at vertices; choose to evaluate at vertices.");
  if (frame.mapped)
    throw Error(PDESC_ERROR_INVALID_ARGUMENT,
                "Displacement and normal maps are followed at vertices only; choose to evaluate at vertices, or clear the maps.");
  settings.descriptors = asked;
  constexpr size_t batch = size_t{1} << 15;
  const TexelMap map = build_texel_map(mesh.triangles, mesh.charts, options.texels);
  const std::vector<vec4> ellipses = sampling_ellipses(mesh.triangles, mesh.charts, frame.forms);
  std::vector<int32_t> ids;
  mesh.context->gl->run([&](const Gl &, ProgramCache &) { ids = mesh.device->buffer->read_ids(); });
  const bool connected = options.relocation == PDESC_RELOCATION_CONNECTED;
  const std::vector<vec4> positions = connected ? measure_cells(mesh) : std::vector<vec4>();
  SiteResults all;
  const size_t count = map.places.size();
  for (size_t first = 0; first < count; first += batch) {
    const size_t last = std::min(first + batch, count);
    frame.centers = texel_centers(map, mesh.triangles, mesh.charts, frame.normals, frame.buffer_frame, ellipses,
                                  settings.radius * ellipse_enlargement, options.seed, first, last);
    if (connected) {
      const auto cells = find_cells(mesh.device->cells, ids, mesh.device->grid, mesh.triangles, mesh.charts,
                                    texel_layout_places(map, mesh.triangles, first, last), mesh.context->threads);
      std::vector<SupportCenter> centers;
      for (size_t i = 0; i < cells.size(); ++i) centers.push_back({vec3(frame.centers[i].position_chart), {}, cells[i]});
      search_supports(mesh, static_cast<double>(settings.radius) / frame.buffer_frame.scale, frame, positions, centers);
    }
    const double share = 0.7 / static_cast<double>(count);
    evaluate(mesh, settings, frame, progress, 0.3 + share * static_cast<double>(first), 0.3 + share * static_cast<double>(last));
    append(all, read_results(mesh, settings, frame));
  }
  field.report.places = static_cast<int32_t>(count);
  keep_map(map, all, field);
  return look_up(map, all, mesh.charts, options.seam_error != 0);
}

static void warn(const Mesh &mesh, Field &field) {
  auto add = [&](const std::string &sentence) { field.warnings += (field.warnings.empty() ? "" : "\n") + sentence; };
  const pdesc_field_report &report = field.report;
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

static void prepare_and_bake(Mesh &mesh, const pdesc_options &options, double radius, Frame &frame) {
  const bool changed = prepare_device(mesh, options);
  frame.buffer_frame = frame_of(mesh.triangles, mesh.half_edges);
  frame.forms = first_fundamental_forms(mesh.triangles, mesh.charts, frame.buffer_frame, mesh.context->threads);
  if (options.relocation != PDESC_RELOCATION_CONNECTED) frame.links = seam_links(mesh.triangles, mesh.charts);
  if (options.relocation == PDESC_RELOCATION_PAPER) frame.seams = number_seams(mesh.charts);
  if (mesh.maps.any())
    frame.mapped =
        map_points(mesh.maps, mesh.triangles, mesh.half_edges, frame.normals, frame.buffer_frame, mesh.context->threads);
  if (frame.mapped) frame.enlargement = ellipse_enlargement * frame.mapped->shrinkage;
  prepare_centers(mesh, options, radius, frame);
  bake(mesh, options, frame, changed);
}

// What overlaps gets a layout of its own, charts that overlap themselves cut into pieces.
static bool part_overlaps(Mesh &mesh) {
  const Cuts cuts = cut_charts(mesh.triangles, mesh.half_edges, mesh.charts);
  if (cuts.overlapping) {
    Charts charts = cuts.cut_charts > 0 ? build_charts(mesh.triangles, mesh.half_edges, cuts.triangle_piece) : mesh.charts;
    repack_charts(mesh.triangles, charts);
    mesh.charts = std::move(charts);
    mesh.cut_charts = cuts.cut_charts;
    mesh.private_layout = PDESC_LAYOUT_OVERLAPS;
  }
  mesh.overlap_free = true;
  return cuts.overlapping;
}

// Gives the mesh a layout of its own, which it keeps, where the UV map overlaps or leaves most of the buffers empty. The device's
// count of overlaps only raises the suspicion: rasterizers round, and small triangles of a sound map may share a texel too.
static bool lay_out_afresh(Mesh &mesh, double radius_in_texels) {
  if (mesh.private_layout) return false;
  const TexelCounts &counts = mesh.device->counts;
  const double size = mesh.device->buffer->size();
  const bool sparse = counts.covered < 0.15 * size * size || radius_in_texels < 4.0;
  if (!mesh.overlap_free && (counts.overlapping > 0 || sparse) && part_overlaps(mesh)) return true;
  if (!sparse || std::exchange(mesh.fill_tried, true)) return false; // it helps at every size and radius, or at none
  if (!repack_charts(mesh.triangles, mesh.charts, 1.5)) return false;
  mesh.private_layout = PDESC_LAYOUT_SPARSE;
  return true;
}

// How far a pass looks around.
static double reach_of(const Pass &pass, const pdesc_options &options, double radius) {
  return pass.stage == Stage::windows ? WINDOW_REACH * options.map_sigma * radius : radius;
}

// Derivatives magnify the noise of what they are taken of, and their own.
static int samples_of(const Pass &pass, const pdesc_options &options) {
  const bool more = pass.stage == Stage::source || pass.stage == Stage::map;
  return more ? std::max(options.samples, std::min(4 * options.samples, 4096)) : options.samples;
}

// Neighborhoods of another radius, from the same cells.
static void widen_supports(Mesh &mesh, const pdesc_options &options, double reach, Frame &frame) {
  prepare_centers(mesh, options, reach, frame);
  if (options.relocation == PDESC_RELOCATION_CONNECTED) prepare_supports(mesh, options, reach, frame);
}

// A pattern over an enlarged ellipse has its samples farther apart: more of them keep as many within the ball.
static int pattern_samples(const pdesc_options &options, const Frame &frame, int samples) {
  if (!frame.mapped || options.relocation == PDESC_RELOCATION_CONNECTED) return samples;
  const auto shrinkage = static_cast<double>(frame.mapped->shrinkage);
  return std::min(4096, static_cast<int>(std::ceil(samples * shrinkage * shrinkage)));
}

static EvaluateSettings settings_of(const Mesh &mesh, const pdesc_options &options, double radius, const Frame &frame) {
  EvaluateSettings settings{};
  settings.samples = pattern_samples(options, frame, options.samples);
  settings.seed = options.seed;
  settings.max_jumps = options.max_jumps;
  settings.pattern = options.pattern;
  settings.ellipse = options.ellipse;
  settings.samples_at_once = samples_at_once(mesh, options);
  settings.chords = options.geodesic == PDESC_GEODESIC_CHORDS;
  settings.radius = static_cast<float>(radius * frame.buffer_frame.scale);
  settings.enlargement = options.relocation == PDESC_RELOCATION_CONNECTED ? ellipse_enlargement : frame.enlargement;
  settings.relocation = options.relocation;
  settings.integral = options.estimator == PDESC_ESTIMATOR_INTEGRAL;
  settings.plain = options.variance_reduction == PDESC_VARIANCE_REDUCTION_NONE;
  settings.geodesic_ball = options.distance == PDESC_DISTANCE_GEODESIC;
  settings.adaptive = static_cast<float>(options.adaptive);
  settings.map_radius = settings.radius;
  settings.map_sigma = static_cast<float>(options.map_sigma) * settings.radius;
  settings.harris_k = static_cast<float>(options.harris_k);
  return settings;
}

// The vertices, pass by pass: operators on a map come after what the map is made of.
static SiteResults evaluate_passes(Mesh &mesh, const pdesc_options &options, std::span<const int> asked,
                                   EvaluateSettings settings, double radius, Frame &frame, const Progress &progress,
                                   Field &field) {
  return run_passes(mesh.half_edges.point_count, asked, find_map(options.map_descriptor),
                    [&](const Pass &pass, const MapValues *map, int number, int count) {
                      const double reach = reach_of(pass, options, radius);
                      if (pass.stage == Stage::windows) {
                        widen_supports(mesh, options, reach, frame);
                        settings.radius = static_cast<float>(reach * frame.buffer_frame.scale);
                      }
                      settings.samples = pattern_samples(options, frame, samples_of(pass, options));
                      if (map) bake_map(mesh, frame, *map);
                      settings.map = map ? mesh.device->map.get() : nullptr;
                      settings.descriptors = pass.rows;
                      const Progress part = [&](const char *stage, double fraction) {
                        return progress(stage, 0.3 + 0.7 * (number + (fraction - 0.3) / 0.7) / count);
                      };
                      return evaluate_vertices(mesh, settings, reach, frame, part, field);
                    });
}

static SiteResults compute_in_texture_space(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, double radius,
                                            const Progress &progress, Field &field) {
  Clock clock;
  Frame frame;
  frame.normals = prepare_normals(mesh, options.normals);
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
  if (connected) build_cells_for(mesh, frame);
  if (connected && !at_texels) prepare_supports(mesh, options, radius, frame);
  field.report.seconds_prepare += clock.lap();
  check_cancel(progress, "evaluate", 0.3);

  const EvaluateSettings settings = settings_of(mesh, options, radius, frame);
  const double radius_in_texels = frame.radius_in_texels;
  SiteResults results = at_texels ? evaluate_texels(mesh, options, asked, settings, frame, progress, field)
                                  : evaluate_passes(mesh, options, asked, settings, radius, frame, progress, field);
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
  ReferenceSettings settings{radius, options.estimator == PDESC_ESTIMATOR_INTEGRAL, options.distance == PDESC_DISTANCE_GEODESIC};
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

Field compute(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, const Progress &progress) {
  const bool reference = mesh.context->backend == PDESC_BACKEND_REFERENCE;
  if (!reference && mesh.triangles.corner_uv.empty())
    throw Error(PDESC_ERROR_INVALID_OPERATION,
                "The mesh has no UV map, which texture space needs; unwrap it, or use the reference backend.");
  if (reference && mesh.maps.any())
    throw Error(
        PDESC_ERROR_INVALID_OPERATION,
        "Displacement and normal maps live in texture space, which the reference backend does without; take the maps away, "
        "or use the gpu or software backend.");
  Clock clock;
  Field field;
  const double radius = resolve_radius(mesh, options);
  check_cancel(progress, "prepare", 0.0);
  const SiteResults results = reference ? compute_in_object_space(mesh, options, asked, radius, progress, field)
                                        : compute_in_texture_space(mesh, options, asked, radius, progress, field);
  for (const int descriptor : asked) field.names.emplace_back(descriptors()[static_cast<size_t>(descriptor)].name);
  gather(mesh.half_edges, results, options.seam_error != 0 && !reference, field);
  field.report.radius = radius;
  field.report.seconds_total = clock.lap();
  if (!reference) warn(mesh, field);
  return field;
}

} // namespace paradesc
