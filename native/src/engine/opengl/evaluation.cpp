// Prepared frame → descriptors at vertices, in passes where operators read a map, or at the texels of a map.
#include <algorithm>
#include <cmath>

#include "compute/passes.h"
#include "descriptor/registry.h"
#include "engine/opengl/stages.h"
#include "kernel/limits.h"
#include "sample/connected_triangles.h"
#include "sample/patch_areas.h"
#include "sample/texels.h"
#include "support/error.h"

namespace paradesc {

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
  for (const int32_t point : frame.points) centers.push_back(values[point]);
  for (size_t i = 0; i < frame.bare.weights.size(); ++i) {
    const auto triangle = static_cast<size_t>(frame.bare.samples[i].triangle);
    auto corner = [&](size_t k) { return values[mesh.half_edges.corner_point[3 * triangle + k]]; };
    const vec2 weights = frame.bare.weights[i];
    bare.push_back(corner(0) * (1.0f - weights.x - weights.y) + corner(1) * weights.x + corner(2) * weights.y);
  }
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &programs) {
    if (!device.map || device.map->size() != device.buffer->size())
      device.map = std::make_unique<MapBuffer>(gl, device.buffer->size());
    device.map->bake(programs, *device.buffer, {mesh.half_edges, device.vertices, values});
    device.evaluator.set_map(gl, centers, bare);
  });
}

// Tiles of about 30 ms keep the callback's latency, and a desktop driver's patience, well within bounds.
static void evaluate_tiles(Mesh &mesh, const EvaluateSettings &settings, int count, const Progress &progress, double from,
                           double to) {
  const int smallest_tile = mesh.context->smallest_tile; // enough for every core of a software device
  const int group = mesh.context->gl->group_size();
  int tile = smallest_tile;
  for (int first = 0; first < count;) {
    const int last = first + std::min({tile, count - first, settings.largest_tile(), mesh.context->gl->largest_dispatch()});
    Clock clock;
    mesh.context->gl->run([&](const Gl &gl, ProgramCache &programs) {
      mesh.device->evaluator.run(gl, programs, *mesh.device->buffer, settings, first, last);
    });
    const double scale = std::clamp(0.03 / std::max(clock.lap(), 1e-4), 0.25, 4.0);
    tile = std::max(smallest_tile, static_cast<int>(tile * scale) / group * group);
    first = last;
    check_cancel(progress, "evaluate", from + (to - from) * first / count);
  }
}

// Of which part of a disk's area it may be another: samples of a folded place miss some per cent, few samples more.
static double same_area(int samples) {
  return std::max(0.06, 1.1 * std::pow(samples / static_cast<double>(ellipse_enlargement * ellipse_enlargement), -0.75));
}

namespace {

// Centers and what their samples say, for a search among triangles.
struct Suspects {
  std::vector<int32_t> centers, points;
  std::vector<double> areas; // in units of the positions

  void push_back(int32_t center, int32_t point, double area) {
    centers.push_back(center);
    points.push_back(point);
    areas.push_back(area);
  }
  Suspects part(size_t first, size_t last) const {
    const auto cut = [&](const auto &all) {
      return std::decay_t<decltype(all)>(all.begin() + static_cast<ptrdiff_t>(first), all.begin() + static_cast<ptrdiff_t>(last));
    };
    return {cut(centers), cut(points), cut(areas)};
  }
  // Keeps those of which keep(i) says so.
  template <class Keep> void filter(const Keep &keep) {
    size_t kept = 0;
    for (size_t i = 0; i < centers.size(); ++i) {
      if (!keep(i)) continue;
      centers[kept] = centers[i];
      points[kept] = points[i];
      areas[kept++] = areas[i];
    }
    centers.resize(kept);
    points.resize(kept);
    areas.resize(kept);
  }
};

} // namespace

// Whether patches are worth it, since floods over triangles would look at each several times, and exact enough: of 300 vertices
// in a ball those that its rim cuts off by chance make 1 % of its area.
static bool floods_are_long(const Mesh &mesh, double radius, size_t points) {
  const double triangles = pi * radius * radius / (0.43 * mesh.mean_edge * mesh.mean_edge); // in a ball
  return triangles > 600.0 && static_cast<double>(points) * std::min(triangles, static_cast<double>(MAX_REACH)) >
                                  16.0 * static_cast<double>(mesh.triangles.triangle_count);
}

// Centers whose neighborhood is no disk, and not what the surface reaches within the ball: once more, on exactly that. So many at
// a time that a run can be cancelled between, and lists of triangles stay short.
static void evaluate_folded(Mesh &mesh, EvaluateSettings settings, double radius, const Frame &frame, const Progress &progress) {
  constexpr size_t batch = 2048;
  std::vector<float> raw;
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { raw = mesh.device->evaluator.read(gl, settings); });
  settings.exact = true;
  const size_t count = frame.centers.size();
  const double unit = frame.buffer_frame.scale * frame.buffer_frame.scale;
  Suspects folded;
  for (size_t i = 0; i < count; ++i)
    if (flags_of(raw[ROW_FLAGS * count + i]) & (frame.plain[i] ? FLAG_FAR_FROM_DISK : FLAG_NO_DISK))
      folded.push_back(static_cast<int32_t>(i), frame.points[i], static_cast<double>(raw[ROW_AREA * count + i]) / unit);
  const Triangles &surface = surface_of(mesh, frame);
  const double tolerance = same_area(settings.samples) * pi * radius * radius;
  if (floods_are_long(mesh, radius, folded.points.size())) { // who has nearly the area that patches tell needs no more
    if (!mesh.patches) mesh.patches = build_patches(mesh.half_edges);
    PatchAreas patches(*mesh.patches, mesh.half_edges, surface, radius, mesh.context->threads);
    const std::vector<double> found = patches.run(folded.points);
    folded.filter([&](size_t i) { return !(found[i] >= 0.0 && std::abs(found[i] - folded.areas[i]) < 0.5 * tolerance); });
  }
  ReachSearch search(surface, mesh.half_edges, radius, MAX_REACH, mesh.context->threads);
  for (size_t first = 0; first < folded.centers.size(); first += batch) {
    const double from = 0.8 + 0.2 * static_cast<double>(first) / static_cast<double>(folded.centers.size());
    check_cancel(progress, "evaluate", from);
    Suspects suspects = folded.part(first, std::min(first + batch, folded.centers.size()));
    Reach reach = search.run(suspects.points, {suspects.areas, tolerance});
    Reach others{{0}, std::move(reach.triangle), {}};
    suspects.filter([&](size_t i) {
      if (reach.begin[i] == reach.begin[i + 1]) return false;
      others.begin.push_back(reach.begin[i + 1]);
      return true;
    });
    if (suspects.centers.empty()) continue;
    mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { mesh.device->evaluator.set_reach(gl, suspects.centers, others); });
    evaluate_tiles(mesh, settings, static_cast<int>(suspects.centers.size()), progress, from, from);
  }
}

// (triangle_count) unit normals; 0 of a triangle without area.
static std::vector<vec4> face_normals(const Triangles &triangles) {
  std::vector<vec4> normals(static_cast<size_t>(triangles.triangle_count));
  for (size_t t = 0; t < normals.size(); ++t) {
    auto corner = [&](size_t k) { return triangles.positions[triangles.corner_vertex[3 * t + k]]; };
    const dvec3 first(corner(0)), normal = cross(dvec3(corner(1)) - first, dvec3(corner(2)) - first);
    const double size = length(normal);
    normals[t] = size > 0.0 ? vec4(vec3(normal / size), 0.0f) : vec4(0.0f);
  }
  return normals;
}

// All centers of the frame, from one fraction of the whole to another.
static void evaluate(Mesh &mesh, const EvaluateSettings &settings, const Frame &frame, const Progress &progress, double from,
                     double to) {
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) {
    mesh.device->evaluator.set_links(gl, frame.links, frame.seams);
    mesh.device->evaluator.set_centers(gl, frame.centers, settings);
    if (settings.faces()) mesh.device->evaluator.set_faces(gl, face_normals(mesh.triangles));
  });
  evaluate_tiles(mesh, settings, static_cast<int>(frame.centers.size()), progress, from, to);
}

static SiteResults read_results(Mesh &mesh, const EvaluateSettings &settings, const Frame &frame) {
  std::vector<float> raw;
  mesh.context->gl->run([&](const Gl &gl, ProgramCache &) { raw = mesh.device->evaluator.read(gl, settings); });
  const size_t count = frame.centers.size();
  SiteResults results;
  results.values.resize(settings.descriptors.size());
  size_t refined = 0, unwritten = 0;
  for (size_t i = 0; i < count; ++i) {
    unwritten += std::isnan(raw[ROW_FLAGS * count + i]);
    results.coverage.push_back(raw[ROW_COVERAGE * count + i]);
    const uint32_t flags = flags_of(raw[ROW_FLAGS * count + i]);
    results.boundary.push_back((flags & FLAG_CUT) != 0);
    refined += (flags & FLAG_ALL_SAMPLES) != 0;
  }
  if (unwritten > 0)
    throw Error(PDESC_ERROR_UNSUPPORTED, "The graphics device left " + std::to_string(unwritten) + " of " +
                                             std::to_string(count) +
                                             " places without a result; use another backend, and please report the device.");
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

// (places, width) by the numbers that they had.
template <class Value> static void put_back(const std::vector<int32_t> &order, std::vector<Value> &values) {
  std::vector<Value> ordered(values.size());
  const size_t width = order.empty() ? 1 : values.size() / order.size();
  for (size_t i = 0; i < values.size(); ++i) ordered[static_cast<size_t>(order[i / width]) * width + i % width] = values[i];
  values.swap(ordered);
}

static void put_back(const std::vector<int32_t> &order, SiteResults &results) {
  for (std::vector<float> &values : results.values) put_back(order, values);
  put_back(order, results.coverage);
  put_back(order, results.boundary);
  put_back(order, results.point);
  put_back(order, results.primary);
}

static SiteResults evaluate_vertices(Mesh &mesh, const EvaluateSettings &settings, double radius, const Frame &frame,
                                     const Progress &progress, Field &field) {
  evaluate(mesh, settings, frame, progress, 0.3, 0.8);
  if (settings.relocation == PDESC_RELOCATION_CONNECTED) evaluate_folded(mesh, settings, radius, frame, progress);
  SiteResults results = read_results(mesh, settings, frame);
  results.point = frame.points;
  for (size_t i = 0; i < frame.points.size(); ++i)
    results.primary.push_back(mesh.charts.point_site[frame.points[i]] == frame.sites[i]);
  field.report.places = static_cast<int32_t>(frame.centers.size());
  put_back(frame.order, results); // passes are read together, each may have had an order of its own
  return results;
}

// How far a pass looks around.
double reach_of(const Pass &pass, const pdesc_options &options, double radius) {
  return pass.stage == Stage::windows ? WINDOW_REACH * options.map_sigma * radius : radius;
}

// Derivatives magnify the noise of what they are taken of, and their own.
static int samples_of(const Pass &pass, const pdesc_options &options) {
  const bool more = pass.stage == Stage::source || pass.stage == Stage::map;
  return more ? std::max(options.samples, std::min(4 * options.samples, 4096)) : options.samples;
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
  if (options.relocation == PDESC_RELOCATION_CONNECTED) settings.cells = mesh.device->cells.front()->buffers.get();
  settings.estimator = options.estimator;
  settings.plain = options.variance_reduction == PDESC_VARIANCE_REDUCTION_NONE;
  settings.mapped = frame.mapped.has_value();
  settings.geodesic_ball = options.distance == PDESC_DISTANCE_GEODESIC;
  settings.adaptive = static_cast<float>(options.adaptive);
  settings.map_radius = settings.radius;
  settings.map_sigma = static_cast<float>(options.map_sigma) * settings.radius;
  settings.harris_k = static_cast<float>(options.harris_k);
  return settings;
}

// The vertices, pass by pass: operators on a map come after what the map is made of.
SiteResults evaluate_at_vertices(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, double radius,
                                 Frame &frame, const Progress &progress, Field &field) {
  EvaluateSettings settings = settings_of(mesh, options, radius, frame);
  std::pair<double, int> prepared{radius, 0}; // for which radius centers are there, and for how many samples neighborhoods
  return run_passes(mesh.half_edges.point_count, asked, find_map(options.map_descriptor),
                    [&](const Pass &pass, const MapValues *map, int number, int count) {
                      const double reach = reach_of(pass, options, radius);
                      const int samples = pattern_samples(options, frame, samples_of(pass, options));
                      const auto before = std::exchange(prepared, {reach, samples});
                      if (before.first != reach) prepare_centers(mesh, options, reach, frame);
                      if (options.relocation == PDESC_RELOCATION_CONNECTED && before != prepared)
                        prepare_supports(mesh, options, reach, samples, frame);
                      settings.radius = static_cast<float>(reach * frame.buffer_frame.scale);
                      settings.samples = samples;
                      if (map) bake_map(mesh, frame, *map);
                      settings.map = map ? mesh.device->map.get() : nullptr;
                      settings.descriptors = pass.rows;
                      const Progress part = [&](const char *stage, double fraction) {
                        return progress(stage, 0.3 + 0.7 * (number + (fraction - 0.3) / 0.7) / count);
                      };
                      return evaluate_vertices(mesh, settings, reach, frame, part, field);
                    });
}

// The texels of a map, and the cells that they start from where these lead to neighborhoods: both depend on the layout alone.
static const TexelMap &prepare_texels(Mesh &mesh, const pdesc_options &options) {
  DeviceMesh &device = *mesh.device;
  if (device.texels.size != options.texels) {
    for (const auto &layout : device.cells) layout->texel_cells.clear();
    device.texels = build_texel_map(mesh.triangles, mesh.charts, options.texels);
  }
  const size_t count = device.texels.places.size();
  if (options.relocation != PDESC_RELOCATION_CONNECTED || device.cells.front()->texel_cells.size() == count) return device.texels;
  CellLayout &layout = *device.cells.front();
  std::vector<int32_t> ids;
  mesh.context->gl->run([&](const Gl &, ProgramCache &) { ids = device.buffer->read_ids(); });
  layout.texel_cells = find_cells(layout.cells, ids, device.grid, mesh.triangles, mesh.charts,
                                  texel_layout_places(device.texels, mesh.triangles, 0, count), mesh.context->threads);
  return device.texels;
}

// The texels of a map, so many at a time that a run can be cancelled between; then the vertices from there.
SiteResults evaluate_at_texels(Mesh &mesh, const pdesc_options &options, std::span<const int> asked, double radius, Frame &frame,
                               const Progress &progress, Field &field) {
  for (const int row : asked)
    if (descriptor_row(row).needs != MapNeeds::nothing)
      throw Error(PDESC_ERROR_INVALID_ARGUMENT, std::string("The operator ") + descriptor_row(row).name +
                                                    " works on a map of values at vertices; choose to evaluate at vertices.");
  if (frame.mapped)
    throw Error(PDESC_ERROR_INVALID_ARGUMENT,
                "Displacement and normal maps are followed at vertices only; choose to evaluate at vertices, or clear the maps.");
  EvaluateSettings settings = settings_of(mesh, options, radius, frame);
  settings.descriptors = asked;
  constexpr size_t batch = size_t{1} << 15;
  const bool connected = options.relocation == PDESC_RELOCATION_CONNECTED;
  const TexelMap &map = prepare_texels(mesh, options);
  const std::vector<vec4> ellipses = connected ? std::vector<vec4>() : ellipses_of(mesh, frame, 1);
  SiteResults all;
  const size_t count = map.places.size();
  for (size_t first = 0; first < count; first += batch) {
    const size_t last = std::min(first + batch, count);
    frame.centers = texel_centers(map, mesh.triangles, mesh.charts, frame.normals, frame.buffer_frame, ellipses,
                                  settings.radius * ellipse_enlargement, options.seed, first, last);
    if (connected) {
      std::vector<SupportCenter> centers;
      for (size_t i = first; i < last; ++i)
        centers.push_back({frame.centers[i - first].position, {}, mesh.device->cells.front()->texel_cells[i]});
      const double own_radius = static_cast<double>(settings.radius) / frame.buffer_frame.scale;
      set_supports(mesh, search_supports(mesh, options, own_radius, settings.samples, frame, centers), frame);
    }
    const double share = 0.7 / static_cast<double>(count);
    evaluate(mesh, settings, frame, progress, 0.3 + share * static_cast<double>(first), 0.3 + share * static_cast<double>(last));
    append(all, read_results(mesh, settings, frame));
  }
  field.report.places = static_cast<int32_t>(count);
  keep_map(map, all, field);
  return look_up(map, all, mesh.charts, options.seam_error != 0, mesh.context->threads);
}

} // namespace paradesc
