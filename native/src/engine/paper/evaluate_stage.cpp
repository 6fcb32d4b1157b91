// Centers → descriptors, in tiles between which a computation can be cancelled.
#include <algorithm>
#include <cmath>
#include <limits>

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

// The pattern is spread over an enlarged ellipse, so it needs more samples to keep as many within the ball.
static int pattern_samples(const Frame &frame, int samples) {
  if (!frame.displaced) return samples;
  const auto shrinkage = static_cast<double>(frame.displaced->shrinkage);
  return std::min(4096, static_cast<int>(std::ceil(samples * shrinkage * shrinkage)));
}

EvaluateSettings TextureSpace::settings_of(const PassInputs &pass, const Job &job, std::span<const int> rows) const {
  const pdesc_options &options = job.options();
  EvaluateSettings settings{};
  settings.descriptors = rows;
  settings.samples = pattern_samples(frame_, samples_of(pass.pass, options));
  settings.seed = options.seed;
  settings.max_jumps = options.max_jumps;
  settings.pattern = options.pattern;
  settings.ellipse = options.ellipse;
  settings.samples_at_once = samples_at_once(software_, job.paper(), options);
  settings.chords = options.geodesic == PDESC_GEODESIC_CHORDS;
  settings.radius = pass.scaled_radius();
  settings.enlargement = frame_.enlargement;
  settings.paper = job.paper();
  settings.estimator = options.estimator;
  settings.use_control_variate = options.variance_reduction != PDESC_VARIANCE_REDUCTION_NONE;
  settings.displaced = frame_.displaced != nullptr;
  settings.geodesic_ball = options.distance == PDESC_DISTANCE_GEODESIC;
  settings.adaptive = static_cast<float>(options.adaptive);
  settings.map = pass.map != nullptr;
  settings.map_radius = static_cast<float>(pass.request.radius * pass.space.scale);
  settings.map_sigma = static_cast<float>(options.map_sigma) * settings.map_radius;
  settings.harris_k = static_cast<float>(options.harris_k);
  return settings;
}

// The smallest tiles still occupy every core of a software device.
void TextureSpace::evaluate_tiles(const Resources &resources, const EvaluateSettings &settings, const Part &progress) {
  const int smallest = resources.smallest_tile, count = device_->evaluator.center_count();
  in_tiles(
      0, count, {smallest, smallest, gl_->largest_dispatch(), gl_->group_size(), resources.tile_seconds},
      [&](int first, int last) {
        gl_->run([&](const Gl &gl, ProgramCache &programs) {
          device_->evaluator.run(gl, programs, *device_->buffer, settings, first, last);
        });
      },
      [&](int last) { progress(static_cast<double>(last) / count); });
}

CenterResults TextureSpace::evaluate(const PassInputs &pass, const std::vector<vec4> &ellipses, const Centers &centers,
                                     std::span<const int> rows, const Part &progress) {
  const Job job{pass.surface, pass.request, pass.resources};
  const EvaluateSettings settings = settings_of(pass, job, rows);
  const std::vector<int32_t> numbers = centers_on_charts(job.charts(), centers);
  const std::vector<CenterData> described =
      describe_centers(job.charts(), {settings.seed, job.options().buffer_size, settings.radius * frame_.enlargement}, centers,
                       numbers, ellipses, frame_.displaced);
  std::vector<vec4> map;
  for (const int32_t i : numbers)
    if (centers.map) map.push_back((*centers.map)[i]);
  gl_->run([&](const Gl &gl, ProgramCache &) {
    device_->evaluator.set_centers(gl, described);
    device_->evaluator.set_map(gl, map);
    device_->evaluator.set_links(gl, frame_.links, frame_.seams);
    device_->evaluator.begin(gl, settings);
  });
  evaluate_tiles(pass.resources, settings, progress);
  gl_->run([&](const Gl &gl, ProgramCache &) { device_->evaluator.read(gl, settings, rows_); });
  CenterResults results = results_of(settings, centers.list.size(), numbers);
  scale_values(rows, pass.space.scale, results);
  return results;
}

// The rows that were read last, for the centers of these numbers among `count`.
CenterResults TextureSpace::results_of(const EvaluateSettings &settings, size_t count,
                                       const std::vector<int32_t> &numbers) const {
  CenterResults results = unknown_results(count, settings.descriptors);
  results.coverage.assign(count, std::numeric_limits<float>::quiet_NaN());
  const size_t read = numbers.size();
  size_t refined = 0, unwritten = 0;
  for (size_t i = 0; i < read; ++i) {
    const uint32_t flags = flags_of(rows_[ROW_FLAGS * read + i]);
    unwritten += std::isnan(rows_[ROW_FLAGS * read + i]);
    results.coverage[numbers[i]] = rows_[ROW_COVERAGE * read + i];
    results.boundary[numbers[i]] = (flags & FLAG_HITS_BOUNDARY) != 0;
    refined += (flags & FLAG_ALL_SAMPLES) != 0;
  }
  if (unwritten > 0)
    throw Error(PDESC_ERROR_UNSUPPORTED, "The graphics device left " + std::to_string(unwritten) + " of " + std::to_string(read) +
                                             " places without a result; use another backend, and please report the device.");
  results.refined_share = read ? static_cast<double>(refined) / static_cast<double>(read) : 1.0;
  size_t row = ROW_DESCRIPTORS;
  for (std::vector<float> &values : results.values) {
    const size_t width = values.size() / std::max<size_t>(count, 1);
    for (size_t component = 0; component < width; ++component, ++row)
      for (size_t i = 0; i < read; ++i) values[static_cast<size_t>(numbers[i]) * width + component] = rows_[row * read + i];
  }
  return results;
}

} // namespace paradesc
