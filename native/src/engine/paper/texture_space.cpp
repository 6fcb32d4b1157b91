// One computation in texture space, stage by stage; compute() is the table of contents.
#include "engine/paper/texture_space.h"

#include <algorithm>
#include <cmath>
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

// The pattern is spread over an enlarged ellipse, so it needs more samples to keep as many within the ball.
static int pattern_samples(const Frame &frame, int samples) {
  if (!frame.displaced) return samples;
  const auto shrinkage = static_cast<double>(frame.displaced->shrinkage);
  return std::min(4096, static_cast<int>(std::ceil(samples * shrinkage * shrinkage)));
}

// Evaluates the vertices pass by pass: operators on a map come after the pass that computes the map.
void TextureSpace::at_vertices(const Job &job, Frame &frame, Computed &computed) {
  const pdesc_options &options = job.options();
  const double radius = job.request.radius;
  EvaluateSettings settings = settings_of(job, frame);
  const Centers centers = list_centers(job.charts(), center_options(job, frame, radius));
  double described = 0.0; // radius of the centers on the device
  const auto run = [&](const Pass &pass, const MapValues *map, int number, int count) {
    const double pass_radius = radius_of(pass, options, radius);
    settings.radius = static_cast<float>(pass_radius * frame.space.scale);
    settings.samples = pattern_samples(frame, samples_of(pass, options));
    settings.descriptors = pass.rows;
    if (std::exchange(described, pass_radius) != pass_radius) {
      const std::vector<CenterData> data = describe(job, frame, centers, pass_radius);
      gl_->run([&](const Gl &gl, ProgramCache &) { device_->evaluator.set_centers(gl, data); });
    }
    if (map) bake_map(job, centers, *map);
    settings.map = map ? device_->map.get() : nullptr;
    const Progress part = [&](const char *stage, double fraction) {
      return job.progress(stage, 0.3 + 0.7 * (number + (fraction - 0.3) / 0.7) / count);
    };
    CenterResults results = evaluate(job, settings, frame, part, 0.3, 1.0);
    results.point = centers.points;
    results.primary = centers.primary;
    CreaseBlend(job.surface, pass.rows, pass_radius, job.resources.threads).at_points(pass.rows, results);
    return results;
  };
  computed.results =
      run_passes(job.surface.half_edges.point_count, job.request.descriptors, find_map(options.map_descriptor), run);
  computed.report.places = static_cast<int32_t>(centers.points.size());
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

// Evaluates the texels of a map in batches, between which a computation can be cancelled; then looks up the vertices there.
void TextureSpace::at_texels(const Job &job, Frame &frame, Computed &computed) {
  refuse_beyond_texels(job, frame);
  const Surface &surface = job.surface;
  const Charts &charts = job.charts();
  EvaluateSettings settings = settings_of(job, frame);
  settings.descriptors = job.request.descriptors;
  const TexelMap &map = texels_.get({frame.key.layout.atlas.atlas, job.options().texels},
                                    [&] { return build_texel_map(charts, job.options().texels); });
  const std::vector<vec4> sizes = ellipses(job, frame.space, 1);
  const CreaseBlend creases(surface, job.request.descriptors, job.request.radius, job.resources.threads);
  CenterResults all;
  const size_t count = map.centers.size();
  const double share = 0.7 / static_cast<double>(count);
  for (size_t first = 0; first < count; first += centers_of_texels) {
    const size_t last = std::min<size_t>(first + centers_of_texels, count);
    const std::vector<CenterData> centers = texel_centers(map, surface.triangles, charts, surface.normals(), frame.space, sizes,
                                                          settings.radius * ellipse_enlargement, job.options().seed, first, last);
    gl_->run([&](const Gl &gl, ProgramCache &) { device_->evaluator.set_centers(gl, centers); });
    CenterResults results = evaluate(job, settings, frame, job.progress, 0.3 + share * static_cast<double>(first),
                                     0.3 + share * static_cast<double>(last));
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
