// Surface and atlas → buffers on the device: the owner of each texel (a layout), and the point of the surface there (a frame).
#include <algorithm>

#include "engine/paper/seam_links.h"
#include "engine/paper/texture_space.h"
#include "support/cancel.h"

namespace paradesc {

// Runs one step on the device; a computation may be cancelled between steps.
void TextureSpace::step(const Work &work) {
  checkpoint();
  gl_->run(work);
}

static int count_texelless_triangles(const Charts &charts, const std::vector<int32_t> &ids) {
  std::vector<uint8_t> seen(charts.triangle_chart.size(), 0);
  for (size_t i = 0; i < ids.size(); i += 2)
    if (ids[i] >= 0 && ids[i + 1] >= 0) seen[ids[i + 1]] = 1;
  int texelless = 0;
  for (size_t i = 0; i < seen.size(); ++i) texelless += charts.triangle_chart[i] >= 0 && !seen[i];
  return texelless;
}

void TextureSpace::bake_layout(const Job &job, const LayoutKey &key) {
  constexpr int drawn_at_once = 1 << 17; // triangles
  const Charts &charts = job.charts();
  const int size = key.atlas.size;
  const BorderGrid &grid = grid_.get(key.atlas, [&] { return build_border_grid(charts, size); });
  layout_.get(key, [&] {
    BakedLayout layout;
    step([&](const Gl &gl, ProgramCache &) {
      baked_.clear();
      if (!device_->buffer || device_->buffer->size() != size || device_->buffer->half() != key.half)
        device_->buffer = std::make_unique<GeometryBuffer>(gl, size, key.half);
      device_->evaluator.set_borders(gl, grid);
      device_->buffer->begin_layout(charts);
    });
    const int count = device_->buffer->triangle_count();
    for (int first = 0; first < count; first += drawn_at_once)
      step([&](const Gl &gl, ProgramCache &programs) {
        device_->buffer->draw_triangles(programs, first, std::min(first + drawn_at_once, count));
        gl.Flush(); // the device draws these while the next ones are prepared
      });
    step([&](const Gl &, ProgramCache &programs) { device_->buffer->draw_borders(programs); });
    step([&](const Gl &, ProgramCache &programs) { layout.counts = device_->buffer->end_layout(programs); });
    step([&](const Gl &, ProgramCache &) {
      layout.texelless_triangles = count_texelless_triangles(charts, device_->buffer->read_ids());
    });
    return layout;
  });
}

void TextureSpace::bake_surface(const Job &job, const Frame &frame) {
  constexpr int drawn_at_once = 1 << 20; // texels
  const Surface &surface = job.surface;
  const Normals &normals = surface.normals();
  const BakeInput input{surface.triangles, job.charts(), frame.space};
  GeometryBuffer &buffer = *device_->buffer;
  const int size = buffer.size(), rows = std::max(1, drawn_at_once / size);
  step([&](const Gl &, ProgramCache &) { buffer.place_corners(input, normals); });
  for (int first = 0; first < size; first += rows)
    step([&](const Gl &gl, ProgramCache &programs) {
      buffer.draw_surface(programs, first, std::min(first + rows, size));
      gl.Flush();
    });
  if (frame.displaced)
    step([&](const Gl &gl, ProgramCache &programs) { device_->mapper.run(gl, programs, buffer, input, normals, surface.maps); });
}

Frame TextureSpace::bake(const Job &job) {
  const Surface &surface = job.surface;
  const pdesc_options &options = job.options();
  Frame frame;
  // Surface maps are applied only to buffers of full precision.
  frame.key.layout = {{surface.atlases.current().version, options.buffer_size},
                      options.precision == PDESC_PRECISION_HALF && !surface.maps.any()};
  frame.key.surface = {surface.positions_version, surface.maps.version, surface.normals.key};
  frame.space = bake_space_of(surface.box);
  if (surface.maps.any()) {
    frame.displaced = &*displaced_.get(frame.key.surface, [&] {
      return displace_points(surface.maps, surface.triangles, surface.half_edges, surface.normals(), frame.space,
                             job.resources.threads);
    });
    frame.enlargement = ellipse_enlargement * frame.displaced->shrinkage;
  } else {
    displaced_.clear();
  }
  bake_layout(job, frame.key.layout);
  baked_.get(frame.key, [&] {
    bake_surface(job, frame);
    return frame.space;
  });
  frame.links = seam_links(surface.triangles, job.charts());
  if (job.paper()) frame.seams = number_seams(job.charts());
  return frame;
}

// Sets the frame's radius in texels.
void TextureSpace::measure_radius(const Job &job, Frame &frame) {
  const Charts &charts = job.charts();
  const size_t step = std::max<size_t>(1, charts.wedges.size() / 128); // a sample is enough for the median
  const std::vector<vec4> sizes = sampling_ellipses(job.surface.triangles, charts, frame.space, step);
  frame.radius_in_texels = median_radius_in_texels(charts, job.options().buffer_size,
                                                   static_cast<float>(job.request.radius * frame.space.scale), sizes, step);
}

} // namespace paradesc
