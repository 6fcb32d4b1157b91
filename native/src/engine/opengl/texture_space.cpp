// One computation in texture space, stage by stage; compute() is the table of contents.
#include "engine/opengl/texture_space.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "descriptor/registry.h"
#include "engine/creases/blend.h"
#include "support/cancel.h"

namespace paradesc {

TextureSpace::~TextureSpace() {
  if (gl_->is_left_behind())
    static_cast<void>(device_.release());
  else
    gl_->run([&](const Gl &, ProgramCache &) { device_.reset(); });
}

int TextureSpace::buffer_size() const { return baked_.key() ? device_->buffer->size() : 0; }

int64_t TextureSpace::bytes_kept_for_others() const {
  const auto bytes = [](const auto &list) { return static_cast<int64_t>(list.capacity() * sizeof(list[0])); };
  int64_t all = 0;
  for (size_t i = 1; i < device_->cells.size(); ++i) {
    const CellSet &set = *device_->cells[i];
    all += 2 * bytes(set.cells.label) + set.buffers->bytes_of_lists(); // labels here and on the device
  }
  return all;
}

// The pattern is spread over an enlarged ellipse, so it needs more samples to keep as many within the ball.
static int pattern_samples(const Job &job, const Frame &frame, int samples) {
  if (!frame.displaced || job.connected()) return samples;
  const auto shrinkage = static_cast<double>(frame.displaced->shrinkage);
  return std::min(4096, static_cast<int>(std::ceil(samples * shrinkage * shrinkage)));
}

// Evaluates the vertices pass by pass: operators on a map come after the pass that computes the map.
void TextureSpace::at_vertices(const Job &job, Frame &frame, Computed &computed) {
  const pdesc_options &options = job.options();
  const double radius = job.request.radius;
  EvaluateSettings settings = settings_of(job, frame);
  const OrderedCenters *const ordered = job.connected() ? &ordered_centers(job, frame) : nullptr;
  const Centers listed = ordered ? Centers() : list_centers(job.charts(), center_options(job, frame, radius));
  const Centers &centers = ordered ? ordered->centers : listed;
  const PlacedCenters *const placed = ordered && !frame.displaced ? &placed_centers(job, frame, *ordered) : nullptr;
  std::pair<double, int> prepared{0.0, 0}; // radius of the centers that are ready, and the sample count of their search
  const auto place_centers = [&](double pass_radius) {
    const std::vector<CenterData> data = placed ? std::vector<CenterData>() : describe(job, frame, centers, pass_radius);
    gl_->run([&](const Gl &gl, ProgramCache &programs) {
      if (!placed) return device_->evaluator.set_centers(gl, data);
      device_->surface.place(gl, programs, placed->places, placed->data.id(), sizeof(CenterData) / sizeof(float));
      device_->evaluator.use_centers(placed->data.id(), placed->places.count());
    });
  };
  const auto run = [&](const Pass &pass, const MapValues *map, int number, int count) {
    const double pass_radius = radius_of(pass, options, radius);
    const int samples = pattern_samples(job, frame, samples_of(pass, options));
    const auto before = std::exchange(prepared, {pass_radius, samples});
    settings.radius = static_cast<float>(pass_radius * frame.space.scale);
    settings.samples = samples;
    settings.descriptors = pass.rows;
    if (before.first != pass_radius) place_centers(pass_radius);
    const auto search = [&] {
      if (!ordered) return;
      prepare_search(job, frame, {settings.radius, samples, options.seed},
                     {ordered->starts, ordered->triangles, ordered->version});
      settings.points = listed_points(job);
    };
    if (before != prepared) search();
    if (map) bake_map(job, centers, ordered ? cells().samples.value() : TexellessSamples(), *map);
    settings.map = map ? device_->map.get() : nullptr;
    const Progress part = [&](const char *stage, double fraction) {
      return job.progress(stage, 0.3 + 0.7 * (number + (fraction - 0.3) / 0.7) / count);
    };
    CenterResults results = evaluate_centers(job, settings, frame, centers, search, part);
    CreaseBlend(job.surface, pass.rows, pass_radius, job.resources.threads).at_points(pass.rows, results);
    return results;
  };
  computed.results =
      run_passes(job.surface.half_edges.point_count, job.request.descriptors, find_map(options.map_descriptor), run);
  computed.report.places = static_cast<int32_t>(centers.points.size());
}

// The texels of a map and, if searches are used, the cells that these start from: both depend on the layout alone.
const TexelMap &TextureSpace::texel_map(const Job &job, const Frame &frame) {
  const int size = job.options().texels;
  const Charts &charts = job.charts();
  const TexelMap &map = texels_.get({frame.key.layout.atlas.atlas, size}, [&] { return build_texel_map(charts, size); });
  if (!job.connected()) return map;
  cells().texel_cells.get(size, [&] {
    std::vector<int32_t> ids;
    gl_->run([&](const Gl &, ProgramCache &) { ids = device_->buffer->read_ids(); });
    return find_cells(cells().cells, ids, grid_.value(), charts, texel_layout_positions(map, charts, 0, map.centers.size()),
                      job.resources.threads);
  });
  return map;
}

static void refuse_beyond_texels(const Job &job, const Frame &frame) {
  for (const int row : job.request.descriptors)
    if (descriptor_row(row).needs != MapNeeds::nothing)
      throw Error(PDESC_ERROR_INVALID_ARGUMENT, std::string("The operator ") + descriptor_row(row).name +
                                                    " works on a map of values at vertices; choose to evaluate at vertices.");
  if (frame.displaced)
    throw Error(PDESC_ERROR_INVALID_ARGUMENT,
                "Displacement and normal maps are followed at vertices only; choose to evaluate at vertices, or clear the maps.");
}

// start: the cell of each texel, or -1.
static Starts starts_of_texels(std::span<const int32_t> start, const Cells &cells) {
  std::vector<int32_t> begin = {0}, list;
  for (const int32_t cell : start) {
    if (cell >= 0) list.push_back(cell);
    begin.push_back(static_cast<int32_t>(list.size()));
  }
  return list_starts(begin, list, cells.count);
}

// Evaluates the texels of a map in batches, between which a computation can be cancelled; then looks up the vertices there.
void TextureSpace::at_texels(const Job &job, Frame &frame, Computed &computed) {
  constexpr size_t batch = size_t{1} << 15;
  refuse_beyond_texels(job, frame);
  const Surface &surface = job.surface;
  const Charts &charts = job.charts();
  EvaluateSettings settings = settings_of(job, frame);
  settings.descriptors = job.request.descriptors;
  const TexelMap &map = texel_map(job, frame);
  const std::vector<vec4> sizes = job.connected() ? std::vector<vec4>() : ellipses(job, frame.space, 1);
  const CreaseBlend creases(surface, job.request.descriptors, job.request.radius, job.resources.threads);
  CenterResults all;
  const size_t count = map.centers.size();
  for (size_t first = 0; first < count; first += batch) {
    const size_t last = std::min(first + batch, count);
    std::vector<CenterData> centers = texel_centers(map, surface.triangles, charts, surface.normals(), frame.space, sizes,
                                                    settings.radius * ellipse_enlargement, job.options().seed, first, last);
    std::vector<int32_t> order(centers.size());
    std::iota(order.begin(), order.end(), 0);
    Starts starts;
    std::vector<int32_t> triangles;
    if (job.connected()) {
      starts = starts_of_texels(std::span(cells().texel_cells.value()).subspan(first, last - first), cells().cells);
      order = starts.order;
      std::vector<CenterData> ordered;
      for (const int32_t i : order) {
        ordered.push_back(centers[i]);
        triangles.push_back(map.centers[first + static_cast<size_t>(i)].triangle);
      }
      centers = std::move(ordered);
    }
    gl_->run([&](const Gl &gl, ProgramCache &) { device_->evaluator.set_centers(gl, centers); });
    const uint64_t version = ++last_version_;
    const auto search = [&] {
      if (!job.connected()) return;
      prepare_search(job, frame, {settings.radius, settings.samples, settings.seed}, {starts, triangles, version});
      settings.points = listed_points(job);
    };
    search();
    const double share = 0.7 / static_cast<double>(count);
    const std::vector<float> &rows = evaluate(job, settings, frame, search, job.progress,
                                              0.3 + share * static_cast<double>(first), 0.3 + share * static_cast<double>(last));
    CenterResults results = results_of(settings, frame, rows, order);
    creases.at_texels(settings.descriptors, map, first, results);
    append(all, std::move(results));
  }
  computed.report.places = static_cast<int32_t>(count);
  computed.images = images_of(map, all, job.request.descriptors);
  computed.image_size = map.size;
  computed.results = look_up(map, all, charts, job.options().seam_error != 0, job.resources.threads);
}

Computed TextureSpace::compute(const Surface &surface, const Request &request, const Resources &resources,
                               const Progress &progress) {
  const Job job{surface, request, resources, progress};
  const pdesc_options &options = request.options;
  Computed computed;
  pdesc_field_report &report = computed.report;
  Clock clock;
  surface.atlases.repack_if_overfull(surface.triangles, surface.half_edges, resources.threads);
  report.seconds_prepare = clock.lap();
  check_cancel(progress, "bake", 0.1);

  Frame frame = bake(job);
  measure_radius(job, frame, request.radius);
  if (surface.atlases.repack_if_needed(surface.triangles, surface.half_edges, layout_.value().counts, options.buffer_size,
                                       frame.radius_in_texels, resources.threads)) {
    frame = bake(job);
    measure_radius(job, frame, request.radius);
  }
  report.radius_in_texels = frame.radius_in_texels;
  report.seconds_bake = clock.lap();
  check_cancel(progress, "prepare", 0.2);

  if (job.connected()) use_cells(job, frame);
  report.seconds_prepare += clock.lap();
  check_cancel(progress, "evaluate", 0.3);

  if (options.evaluate == PDESC_EVALUATE_TEXEL)
    at_texels(job, frame, computed);
  else
    at_vertices(job, frame, computed);
  const Atlas &atlas = surface.atlases.current();
  report.private_layout = atlas.layout;
  report.cut_charts = atlas.cut_charts;
  report.overlapping_texels = layout_.value().counts.overlapping;
  report.covered_texels = layout_.value().counts.covered;
  report.bare_triangles = layout_.value().texelless_triangles;
  report.buffer_megabytes = device_->buffer->megabytes();
  report.refined_share = computed.results.refined_share;
  report.seconds_evaluate = clock.lap();
  return computed;
}

std::unique_ptr<Session> open_texture_space(std::shared_ptr<GlThread> thread, bool software) {
  return std::make_unique<TextureSpace>(std::move(thread), software);
}

} // namespace paradesc
