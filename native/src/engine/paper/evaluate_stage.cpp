// Centers → descriptors, in tiles between which a computation can be cancelled.
#include <cmath>

#include "descriptor/registry.h"
#include "engine/paper/dispatch.h"
#include "engine/paper/texture_space.h"

namespace paradesc {

// The number of samples that march in one dispatch. llvmpipe silently ends an invocation's loops after 65535 iterations (Mesa's
// LP_MAX_TGSI_LOOP_ITERATIONS), counted over the eight invocations of one vector together.
static int samples_at_once(bool software, bool paper, const pdesc_options &options) {
  if (!software) return options.samples;
  const int samples = paper ? 8 : 64; // each marches up to MAX_VISITS steps
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
  settings.samples_at_once = samples_at_once(software_, job.paper(), options);
  settings.chords = options.geodesic == PDESC_GEODESIC_CHORDS;
  settings.radius = static_cast<float>(job.request.radius * frame.space.scale);
  settings.enlargement = frame.enlargement;
  settings.paper = job.paper();
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

// Bakes the map for every place that samples read: texels and centers.
void TextureSpace::bake_map(const Job &job, const Centers &centers, const MapValues &values) {
  std::vector<vec4> at_centers;
  for (const int32_t point : centers.points) at_centers.push_back(values[point]);
  gl_->run([&](const Gl &gl, ProgramCache &programs) {
    if (!device_->map || device_->map->size() != device_->buffer->size())
      device_->map = std::make_unique<MapBuffer>(gl, device_->buffer->size());
    device_->map->bake(programs, *device_->buffer, {job.surface.half_edges, vertices_.value(), values});
    device_->evaluator.set_map(gl, at_centers);
  });
}

// The smallest tiles still occupy every core of a software device.
void TextureSpace::evaluate_tiles(const Job &job, const EvaluateSettings &settings, int count, const Progress &progress,
                                  double from, double to) {
  const int smallest = job.resources.smallest_tile;
  in_tiles(
      0, count, {smallest, smallest, gl_->largest_dispatch(), gl_->group_size(), job.resources.tile_seconds},
      [&](int first, int last) {
        gl_->run([&](const Gl &gl, ProgramCache &programs) {
          device_->evaluator.run(gl, programs, *device_->buffer, settings, first, last);
        });
      },
      [&](int last) { check_cancel(progress, "evaluate", from + (to - from) * last / count); });
}

// Evaluates the evaluator's centers; progress goes from one fraction of the whole to another. The results have no points yet.
CenterResults TextureSpace::evaluate(const Job &job, const EvaluateSettings &settings, const Frame &frame,
                                     const Progress &progress, double from, double to) {
  const int count = device_->evaluator.center_count();
  gl_->run([&](const Gl &gl, ProgramCache &programs) {
    device_->evaluator.set_links(gl, frame.links, frame.seams);
    device_->evaluator.begin(gl, settings);
    if (settings.faces()) device_->evaluator.use_faces(device_->surface.faces(gl, programs));
  });
  evaluate_tiles(job, settings, count, progress, from, to);
  gl_->run([&](const Gl &gl, ProgramCache &) { device_->evaluator.read(gl, settings, rows_); });
  return results_of(settings, frame, static_cast<size_t>(count));
}

// The rows that were read last, in units of the positions.
CenterResults TextureSpace::results_of(const EvaluateSettings &settings, const Frame &frame, size_t count) const {
  CenterResults results;
  results.values.resize(settings.descriptors.size());
  results.coverage.resize(count);
  results.boundary.resize(count);
  size_t refined = 0, unwritten = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t flags = flags_of(rows_[ROW_FLAGS * count + i]);
    unwritten += std::isnan(rows_[ROW_FLAGS * count + i]);
    results.coverage[i] = rows_[ROW_COVERAGE * count + i];
    results.boundary[i] = (flags & FLAG_HITS_BOUNDARY) != 0;
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
      for (size_t i = 0; i < count; ++i) results.values[k][i * width + component] = in_unit(rows_[row * count + i], unit);
  }
  return results;
}

} // namespace paradesc
