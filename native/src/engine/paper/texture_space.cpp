// One computation in texture space, stage by stage: what its passes share, then each pass.
#include "engine/paper/texture_space.h"

namespace paradesc {

TextureSpace::~TextureSpace() {
  if (gl_->is_left_behind())
    static_cast<void>(device_.release());
  else
    gl_->run([&](const Gl &, ProgramCache &) { device_.reset(); });
}

int TextureSpace::buffer_size() const { return baked_.key() ? device_->buffer->size() : 0; }

void TextureSpace::prepare(const Surface &surface, const Request &request, const Resources &resources, const Progress &progress,
                           pdesc_field_report &report) {
  const Job job{surface, request, resources};
  const pdesc_options &options = request.options;
  if (options.evaluate == PDESC_EVALUATE_TEXEL && surface.maps.any())
    throw Error(PDESC_ERROR_INVALID_ARGUMENT,
                "Displacement and normal maps are followed at vertices only; choose to evaluate at vertices, or clear the maps.");
  Clock clock;
  surface.atlases.repack_if_overfull(surface.triangles, surface.half_edges, resources.threads);
  report.seconds_prepare += clock.lap();
  check_cancel(progress, "bake", 0.1);

  const auto bake_and_measure = [&] {
    frame_ = bake(job);
    measure_radius(job, frame_);
  };
  bake_and_measure();
  if (surface.atlases.repack_if_needed(surface.triangles, surface.half_edges, layout_.value().counts, options.buffer_size,
                                       frame_.radius_in_texels, resources.threads))
    bake_and_measure();
  report.radius_in_texels = frame_.radius_in_texels;
  report.overlapping_texels = layout_.value().counts.overlapping;
  report.covered_texels = layout_.value().counts.covered;
  report.bare_triangles = layout_.value().texelless_triangles;
  report.buffer_megabytes = device_->buffer->megabytes();
  report.seconds_bake = clock.lap();
}

EvaluatePass TextureSpace::start(const PassInputs &pass) {
  if (pass.map)
    gl_->run(
        [&](const Gl &, ProgramCache &programs) { device_->buffer->draw_map(programs, pass.surface.half_edges, *pass.map); });
  const Job job{pass.surface, pass.request, pass.resources};
  if (settings_of(pass, job, pass.pass.rows).faces())
    gl_->run([&](const Gl &gl, ProgramCache &) { device_->evaluator.set_faces(gl, pass.surface.triangles); });
  return [this, &pass, sizes = sampling_ellipses(pass.surface.triangles, job.charts(), pass.space)](
             const Centers &centers, std::span<const int> rows, const Part &progress) {
    return evaluate(pass, sizes, centers, rows, progress);
  };
}

} // namespace paradesc
