// Baked buffers → cells of their texels, the samples of each, and the neighborhoods that centers have among them.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/opengl/texture_space.h"
#include "support/cancel.h"
#include "support/free_memory.h"

namespace paradesc {

// About half the radius: a neighborhood then meets a few dozen cells, at every radius; more where samples lie farther apart than
// that. One invocation measures a cell, and software devices limit its loops (shared.h).
static int block_size(double radius_in_texels, int samples, int buffer_size) {
  constexpr int largest = 128;
  static_assert(largest * (largest + 1) < MAX_ITERATIONS);
  const double apart = radius_in_texels * std::sqrt(pi / samples), least = std::max(radius_in_texels / 3.0, 1.5 * apart);
  int size = 4;
  while (size <= least && size * 2 <= std::min(buffer_size, largest)) size *= 2;
  return size;
}

// Makes the cells for the frame's radius the first of those that are kept.
void TextureSpace::use_cells(const Job &job, const Frame &frame) {
  const int buffer_size = device_->buffer->size();
  const int size = block_size(frame.radius_in_texels, job.options().samples, buffer_size);
  auto &kept = device_->cells;
  const auto found = std::ranges::find_if(kept, [&](const auto &set) { return set->cells.block_size == size; });
  if (found != kept.end()) {
    std::rotate(kept.begin(), found, found + 1);
    return;
  }
  // Several radii may take turns in an animation; the lists of large buffers are too large to keep several.
  const size_t max_kept = buffer_size <= 1024 ? 3 : 1;
  auto set = std::make_unique<CellSet>();
  std::vector<int32_t> ids;
  gl_->run([&](const Gl &, ProgramCache &) {
    ids = device_->buffer->read_ids();
    if (kept.size() >= max_kept) kept.resize(max_kept - 1);
  });
  set->cells =
      build_cells(ids, grid_.value(), job.surface.triangles, job.surface.half_edges, job.charts(), size, job.resources.threads);
  gl_->run([&](const Gl &gl, ProgramCache &) {
    set->buffers = std::make_unique<CellBuffers>(gl, set->cells, buffer_size);
    kept.insert(kept.begin(), std::move(set));
  });
}

const std::vector<CellData> &TextureSpace::measured_cells(const Frame &frame) {
  return cells().measured.get(frame.key, [&] {
    std::vector<CellData> measured;
    gl_->run([&](const Gl &gl, ProgramCache &programs) { measured = cells().buffers->measure(gl, programs, *device_->buffer); });
    return measured;
  });
}

const std::vector<vec3> &TextureSpace::link_points(const Frame &frame) {
  return cells().link_points.get(frame.key, [&] {
    std::vector<vec3> points;
    gl_->run([&](const Gl &gl, ProgramCache &programs) {
      points = read_points(gl, programs, *device_->buffer, cells().cells.link_texel);
    });
    return points;
  });
}

// The samples of the cells for a radius in buffer units. Lists are kept from frame to frame while they stay the same.
void TextureSpace::list_samples_for(const Job &job, const Frame &frame, float radius, int samples) {
  CellSet &set = cells();
  const int size = device_->buffer->size(), threads = job.resources.threads;
  CellStrides strides = choose_strides(set.cells, measured_cells(frame), size, radius, samples, job.options().seed, threads);
  if (strides == set.samples.strides) return;
  set.samples = {};
  CellSamples listed = list_samples(set.cells, std::move(strides), size, threads);
  gl_->run([&](const Gl &gl, ProgramCache &) { set.buffers->set_samples(gl, listed); });
  set.samples = std::move(listed);
  set.samples_version = ++last_samples_version_;
}

// The neighborhoods of centers, before any sample is fetched. texelless: the samples of triangles without texels.
Neighborhoods TextureSpace::search(const Job &job, const Frame &frame, double radius, int samples,
                                   const std::vector<SearchCenter> &centers, TexellessSamples &texelless) {
  const auto buffer_radius = static_cast<float>(radius * frame.space.scale);
  checkpoint();
  list_samples_for(job, frame, buffer_radius, samples);
  const CellSet &set = cells();
  const Surface &surface = job.surface;
  const DisplacedSurface displaced(surface.maps, surface.triangles, surface.normals, frame.space);
  texelless = sample_texelless_triangles(set.cells, surface.triangles, surface.normals, frame.space, buffer_radius,
                                         frame.displaced ? &displaced : nullptr);
  const SearchSpace space{set.cells,
                          set.samples,
                          measured_cells(frame),
                          texelless,
                          job.triangles(frame),
                          frame.space,
                          [&]() -> const std::vector<vec3> & { return link_points(frame); },
                          job.options().adaptive > 0.0};
  // Ranges of samples three times: in parts, as one list, and on the device.
  const auto max_ranges = static_cast<size_t>(allowed_memory(job.resources.memory_limit, 0)) / (3 * sizeof(ivec2));
  return paradesc::find_neighborhoods(space, centers, buffer_radius, job.resources.threads, max_ranges);
}

// The points of the samples, if they are listed; null: samples fetch texels.
const BufferTexture *TextureSpace::listed_points(const Job &job, const Frame &frame) {
  return job.connected() && listed_points_.find(points_key(frame)) ? &device_->points : nullptr;
}

void TextureSpace::upload(const Neighborhoods &neighborhoods, const TexellessSamples &texelless, const Frame &frame) {
  // Listing a point costs a few fetches of it.
  constexpr size_t worth = 4;
  size_t fetches = 0;
  for (const ivec2 range : neighborhoods.range) fetches += static_cast<size_t>(range.y - range.x);
  const CellSet &set = cells();
  const PointsKey key = points_key(frame);
  if (!listed_points_.find(key) && fetches > worth * set.samples.list.size()) {
    bool listed = false;
    listed_points_.clear();
    gl_->run([&](const Gl &gl, ProgramCache &programs) {
      listed = set.buffers->list_points(gl, programs, *device_->buffer, device_->points);
    });
    if (listed) listed_points_.get(key, [] { return true; });
  }
  checkpoint();
  gl_->run([&](const Gl &gl, ProgramCache &) { device_->evaluator.set_neighborhoods(gl, neighborhoods, texelless); });
  checkpoint();
}

// The wedges, sorted by point; begin: (points + 1) where those of each point start.
static std::vector<int32_t> wedges_by_point(const Charts &charts, int point_count, std::vector<int32_t> &begin) {
  begin.assign(static_cast<size_t>(point_count) + 1, 0);
  for (const Wedge &wedge : charts.wedges) ++begin[wedge.point + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int32_t> order(charts.wedges.size()), next(begin.begin(), begin.end() - 1);
  for (size_t i = 0; i < order.size(); ++i) order[next[charts.wedges[i].point]++] = static_cast<int32_t>(i);
  return order;
}

// Finds and uploads the neighborhoods of all centers, which this puts into another order.
TexellessSamples TextureSpace::find_neighborhoods(const Job &job, const Frame &frame, double radius, int samples,
                                                  Centers &centers) {
  const HalfEdges &half_edges = job.surface.half_edges;
  std::vector<int32_t> begin;
  const std::vector<int32_t> wedges = wedges_by_point(job.charts(), half_edges.point_count, begin);
  std::vector<SearchCenter> starts;
  starts.reserve(centers.data.size());
  for (size_t i = 0; i < centers.data.size(); ++i) {
    const int32_t point = centers.points[i];
    // A center starts from all wedges of its point; for seam errors each wedge has to find the others by itself.
    const bool alone = job.options().seam_error && centers.wedges[i] >= 0;
    const std::span<const int32_t> from = alone ? std::span<const int32_t>(centers.wedges).subspan(i, 1)
                                                : std::span(wedges).subspan(begin[point], begin[point + 1] - begin[point]);
    starts.push_back({centers.data[i].position, from,
                      centers.wedges[i] < 0 ? cells().cells.triangle_cell[half_edges.point_half_edge[point] / 3] : -1});
  }
  TexellessSamples texelless;
  Neighborhoods found = search(job, frame, radius, samples, starts, texelless);
  checkpoint();
  // Invocations side by side then have much the same samples, and as many.
  centers.single_sheet = std::move(found.single_sheet);
  const std::vector<int32_t> order = std::move(found.order);
  centers.permute(order);
  found.permute(order);
  upload(found, texelless, frame);
  return texelless;
}

} // namespace paradesc
