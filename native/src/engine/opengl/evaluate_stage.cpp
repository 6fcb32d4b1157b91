// Centers and their neighborhoods → descriptors, in tiles between which a computation can be cancelled.
#include <algorithm>
#include <cmath>
#include <limits>

#include "descriptor/registry.h"
#include "engine/opengl/dispatch.h"
#include "engine/opengl/texture_space.h"

namespace paradesc {

// The number of samples that march in one dispatch. llvmpipe ends an invocation's loops after 65535 iterations (shared.h),
// counted over the eight invocations of one vector together.
static int samples_at_once(bool software, const pdesc_options &options) {
  if (!software) return options.samples;
  const int samples = options.relocation == PDESC_RELOCATION_PAPER ? 8 : 64; // each marches up to MAX_VISITS steps
  return options.geodesic == PDESC_GEODESIC_CHORDS ? samples / 8 : samples;
}

EvaluateSettings TextureSpace::settings_of(const Job &job, const Frame &frame) {
  const pdesc_options &options = job.options();
  EvaluateSettings settings{};
  settings.samples = options.samples;
  settings.seed = options.seed;
  settings.max_jumps = options.max_jumps;
  settings.pattern = options.pattern;
  settings.ellipse = options.ellipse;
  settings.samples_at_once = samples_at_once(software_, options);
  settings.chords = options.geodesic == PDESC_GEODESIC_CHORDS;
  settings.radius = static_cast<float>(job.request.radius * frame.space.scale);
  settings.enlargement = job.connected() ? ellipse_enlargement : frame.enlargement;
  settings.relocation = options.relocation;
  if (job.connected()) {
    settings.cells = cells().buffers.get();
    settings.search = &device_->search;
    settings.connected = &device_->connected;
  }
  settings.estimator = options.estimator;
  settings.use_control_variate = options.variance_reduction != PDESC_VARIANCE_REDUCTION_NONE;
  settings.displaced = frame.displaced != nullptr;
  settings.geodesic_ball = options.distance == PDESC_DISTANCE_GEODESIC;
  settings.adaptive = static_cast<float>(options.adaptive);
  settings.map_radius = settings.radius;
  settings.map_sigma = static_cast<float>(options.map_sigma) * settings.radius;
  settings.harris_k = static_cast<float>(options.harris_k);
  return settings;
}

// Bakes the map for every place that samples read: texels, centers, and triangles without texels.
void TextureSpace::bake_map(const Job &job, const Centers &centers, const TexellessSamples &texelless, const MapValues &values) {
  const HalfEdges &half_edges = job.surface.half_edges;
  std::vector<vec4> at_centers, at_texelless;
  for (const int32_t point : centers.points) at_centers.push_back(values[point]);
  for (size_t i = 0; i < texelless.weights.size(); ++i) {
    const int32_t triangle = texelless.samples[i].triangle;
    auto corner = [&](int k) { return values[half_edges.corner_point[3 * triangle + k]]; };
    const vec2 weights = texelless.weights[i];
    at_texelless.push_back(corner(0) * (1.0f - weights.x - weights.y) + corner(1) * weights.x + corner(2) * weights.y);
  }
  gl_->run([&](const Gl &gl, ProgramCache &programs) {
    if (!device_->map || device_->map->size() != device_->buffer->size())
      device_->map = std::make_unique<MapBuffer>(gl, device_->buffer->size());
    device_->map->bake(programs, *device_->buffer, {half_edges, vertices_.value(), values});
    device_->evaluator.set_map(gl, at_centers, at_texelless);
  });
}

// Evaluates all centers in tiles, between which a computation can be cancelled. The smallest tiles still occupy every core of a
// software device. A frame starts with the tile size that the previous frame ended with, since cards are slow on small tiles.
void TextureSpace::evaluate_tiles(const Job &job, const EvaluateSettings &settings, int count, const Progress &progress,
                                  double from, double to) {
  const int smallest = job.resources.smallest_tile;
  const TileSizes sizes{job.connected() ? std::max(cells().tile, smallest) : smallest, smallest, gl_->largest_dispatch(),
                        gl_->group_size(), job.resources.tile_seconds};
  const int next = in_tiles(
      0, count, sizes,
      [&](int first, int last) {
        gl_->run([&](const Gl &gl, ProgramCache &programs) {
          device_->evaluator.run(gl, programs, *device_->buffer, settings, first, last);
        });
      },
      [&](int last) { check_cancel(progress, "evaluate", from + (to - from) * last / count); });
  if (job.connected()) cells().tile = next;
}

// The number of ambiguous centers that are checked before the time of a check and their total number are known.
static constexpr int first_round = 4096;

// Checks the ambiguous centers [first, end) in rounds that take as long as tiles. Rounds past the last ambiguous center take next
// to no time, so they grow quickly.
void TextureSpace::check_connected(const EvaluateSettings &settings, int first, int end, const Progress &progress, double from,
                                   double to) {
  const int smallest = gl_->group_size() * 16;
  in_tiles(
      first, end, {first_round, smallest, std::numeric_limits<int>::max(), gl_->group_size()},
      [&](int begin, int last) {
        gl_->run([&](const Gl &gl, ProgramCache &programs) {
          device_->evaluator.check(gl, programs, *device_->buffer, device_->surface, settings, begin, last);
        });
      },
      [&](int last) { check_cancel(progress, "evaluate", from + (to - from) * last / device_->evaluator.center_count()); });
}

// Evaluates the evaluator's centers; progress goes from one fraction of the whole to another. search: repeats the search for
// neighborhoods after a list of the search was too short. Returns the rows of results as the device has them, valid until the
// next call.
const std::vector<float> &TextureSpace::evaluate(const Job &job, const EvaluateSettings &settings, const Frame &frame,
                                                 const std::function<void()> &search, const Progress &progress, double from,
                                                 double to) {
  const double checked_from = job.connected() ? from + 0.8 * (to - from) : to;
  const int count = device_->evaluator.center_count();
  for (;;) {
    gl_->run([&](const Gl &gl, ProgramCache &programs) {
      device_->evaluator.set_links(gl, frame.links, frame.seams);
      device_->evaluator.begin(gl, settings);
      if (settings.faces()) device_->evaluator.use_faces(device_->surface.faces(gl, programs));
    });
    evaluate_tiles(job, settings, count, progress, from, checked_from);
    int checked = 0, ambiguous = job.connected() ? cells().ambiguous : 0; // only the device knows how many there are
    do {
      if (job.connected()) {
        const int end = std::min(count, std::max(ambiguous, checked + first_round));
        check_connected(settings, checked, end, progress, checked_from, to);
        checked = end;
      }
      gl_->run([&](const Gl &gl, ProgramCache &) { device_->evaluator.read(gl, settings, evaluated_); });
      ambiguous = std::min(evaluated_.ambiguous, count);
    } while (ambiguous > checked);
    if (!job.connected()) return evaluated_.rows;
    cells().ambiguous = ambiguous + ambiguous / 8;
    const bool lists_fit = had_room(evaluated_.counts);
    if (lists_fit && floods_had_room(evaluated_.patches)) return evaluated_.rows;
    if (!lists_fit) search();
  }
}

// rows: as evaluate() returns them. order: the place of each center among the results.
CenterResults TextureSpace::results_of(const EvaluateSettings &settings, const Frame &frame, const std::vector<float> &rows,
                                       std::span<const int32_t> order) {
  const size_t count = order.size();
  CenterResults results;
  results.values.resize(settings.descriptors.size());
  results.coverage.resize(count);
  results.boundary.resize(count);
  size_t refined = 0, unwritten = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t flags = flags_of(rows[ROW_FLAGS * count + i]);
    unwritten += std::isnan(rows[ROW_FLAGS * count + i]);
    results.coverage[order[i]] = rows[ROW_COVERAGE * count + i];
    results.boundary[order[i]] = (flags & FLAG_HITS_BOUNDARY) != 0;
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
    const double unit = std::pow(frame.space.scale, -descriptor.length_power);
    const auto width = static_cast<size_t>(descriptor.components);
    results.values[k].resize(count * width);
    for (size_t component = 0; component < width; ++component, ++row)
      for (size_t i = 0; i < count; ++i)
        results.values[k][static_cast<size_t>(order[i]) * width + component] = in_unit(rows[row * count + i], unit);
  }
  return results;
}

// Results are in the order in which the centers were listed: passes are read together, and each may have its own order.
CenterResults TextureSpace::evaluate_centers(const Job &job, const EvaluateSettings &settings, const Frame &frame,
                                             const Centers &centers, const std::function<void()> &search,
                                             const Progress &progress) {
  const std::vector<float> &rows = evaluate(job, settings, frame, search, progress, 0.3, 1.0);
  CenterResults results = results_of(settings, frame, rows, centers.order);
  results.point = centers.listed_point;
  results.primary = centers.listed_primary;
  return results;
}

} // namespace paradesc
