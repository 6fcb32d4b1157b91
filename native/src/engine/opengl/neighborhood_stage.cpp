// Baked buffers → cells of their texels, the samples of each cell, and the inputs of the search for neighborhoods.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/opengl/texture_space.h"
#include "support/cancel.h"

namespace paradesc {

// Blocks are wider if samples lie farther apart. One invocation measures a cell, and software devices limit its loops (shared.h).
int block_size(double radius_in_texels, int samples, int buffer_size) {
  constexpr int largest = 128;
  static_assert(largest * (largest + 1) < MAX_ITERATIONS);
  const double apart = radius_in_texels * std::sqrt(pi / samples), least = std::max(radius_in_texels / 3.0, 1.5 * apart);
  int size = 4;
  while (size <= least && size * 2 <= std::min(buffer_size, largest)) size *= 2;
  return size;
}

// Moves the cells for the frame's radius to the front of those that are kept, making them if there are none.
void TextureSpace::use_cells(const Job &job, const Frame &frame) {
  const int buffer_size = device_->buffer->size();
  const int size = block_size(frame.radius_in_texels, job.options().samples, buffer_size);
  auto &kept = device_->cells;
  const auto found = std::ranges::find_if(kept, [&](const auto &set) { return set->cells.block_size == size; });
  if (found != kept.end()) {
    std::rotate(kept.begin(), found, found + 1);
    return;
  }
  // Several radii may alternate in an animation; the lists of large buffers are too large to keep several.
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

// (cells.boundary, 2) the ends of half-edges, in buffer units.
static std::vector<vec4> ends_of_boundary(const Cells &cells, const Triangles &triangles, const BakeSpace &space) {
  std::vector<vec4> ends;
  for (const int32_t half_edge : cells.boundary)
    for (const int corner : {half_edge, next_corner(half_edge)})
      ends.emplace_back(space.to_buffer(triangles.positions[triangles.corner_vertex[corner]]), 0.0f);
  return ends;
}

// If the device fits normals, the processor computes them only at the corners of these triangles.
static TexellessSamples texelless_samples(const Job &job, const Frame &frame, const Cells &cells, float radius) {
  if (cells.texelless.empty()) return {};
  const Surface &surface = job.surface;
  if (!frame.key.surface.fits_normals) {
    const Normals &normals = surface.normals();
    const DisplacedSurface displaced(surface.maps, surface.triangles, normals, frame.space);
    return sample_texelless_triangles(
        cells, surface.triangles, [&](size_t corner) { return normals.corner(corner); }, frame.space, radius,
        frame.displaced ? &displaced : nullptr);
  }
  const NormalRings &rings = surface.normals.rings();
  std::vector<int32_t> fans;
  for (const int32_t triangle : cells.texelless)
    for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) fans.push_back((*rings.corner_fan)[corner]);
  std::ranges::sort(fans);
  fans.erase(std::unique(fans.begin(), fans.end()), fans.end());
  const std::vector<vec3> normals =
      compute_fan_normals(surface.triangles, rings, surface.normals.kind, fans, job.resources.threads);
  return sample_texelless_triangles(
      cells, surface.triangles,
      [&](size_t corner) { return normals[std::ranges::lower_bound(fans, (*rings.corner_fan)[corner]) - fans.begin()]; },
      frame.space, radius);
}

// The samples of triangles without texels.
const TexellessSamples &TextureSpace::list_samples(const Job &job, const Frame &frame, const CellSampling &sampling) {
  CellSet &set = cells();
  set.measured.get(frame.key, [&] {
    gl_->run([&](const Gl &gl, ProgramCache &programs) { set.buffers->measure(gl, programs, *device_->buffer); });
    return true;
  });
  return set.samples.get({frame.key, sampling}, [&] {
    listed_points_.clear();
    TexellessSamples texelless = texelless_samples(job, frame, set.cells, sampling.radius);
    gl_->run([&](const Gl &gl, ProgramCache &programs) { set.buffers->list_samples(gl, programs, sampling, texelless); });
    return texelless;
  });
}

// The number of triangles in a disk around centers, which lie on these triangles.
static double triangles_in_disk(const Job &job, std::span<const int32_t> triangles, double radius) {
  const Triangles &surface = job.surface.triangles;
  const size_t step = triangles.size() / 1024 + 1;
  double area = 0.0, count = 0.0;
  for (size_t i = 0; i < triangles.size(); i += step, ++count) {
    const int32_t corner = 3 * triangles[i];
    const dvec3 at(surface.position(corner)), first(surface.position(corner + 1)), second(surface.position(corner + 2));
    area += 0.5 * glm::length(glm::cross(first - at, second - at));
  }
  return area > 0.0 ? pi * radius * radius * count / area : 0.0;
}

// Makes the inputs of the check of ambiguous centers.
void TextureSpace::prepare_check(const Job &job, const Frame &frame, const SearchStarts &starts) {
  const Surface &surface = job.surface;
  if (patch_codes_.empty()) {
    Patches patches = build_patches(surface.half_edges);
    gl_->run(
        [&](const Gl &gl, ProgramCache &) { device_->connected.set_mesh(gl, surface.triangles, surface.half_edges, patches); });
    patch_codes_ = std::move(patches.code);
  }
  patches_.get(frame.key.surface, [&] {
    gl_->run([&](const Gl &gl, ProgramCache &programs) { device_->connected.measure(gl, programs, device_->surface); });
    return true;
  });
  if (checked_starts_ == starts.version) return;
  std::vector<int32_t> codes;
  codes.reserve(starts.triangles.size());
  for (const int32_t triangle : starts.triangles) codes.push_back(patch_codes_[triangle]);
  gl_->run([&](const Gl &gl, ProgramCache &) { device_->connected.set_starts(gl, codes); });
  checked_starts_ = starts.version;
}

// Makes the inputs of the search for neighborhoods of the evaluator's centers.
void TextureSpace::prepare_search(const Job &job, const Frame &frame, const CellSampling &sampling, const SearchStarts &starts) {
  CellSet &set = cells();
  prepare_check(job, frame, starts);
  if (set.room != sampling) {
    set.flood_room = expected_patches(triangles_in_disk(job, starts.triangles, sampling.radius / frame.space.scale));
    set.tile = 0; // a frame without room in its lists found nothing, and took no time
  }
  device_->connected.expect(set.flood_room);
  const std::vector<vec4> boundary = ends_of_boundary(set.cells, job.triangles(frame), frame.space);
  for (bool enough = false; !enough;) {
    checkpoint();
    list_samples(job, frame, sampling);
    enough = set.room == sampling;
    gl_->run([&](const Gl &gl, ProgramCache &programs) {
      device_->search.set_starts(gl, starts.starts, starts.version);
      device_->search.set(gl, programs, *set.buffers, {device_->evaluator.centers(), boundary, job.options().adaptive > 0.0});
    });
    if (!enough) {
      SearchCounts counts;
      gl_->run([&](const Gl &gl, ProgramCache &) { counts = set.buffers->read_counts(gl); });
      enough = had_room(counts, true);
    }
  }
  set.room = sampling;
  list_points(starts.triangles.size());
  checkpoint();
}

// Calls CellBuffers::make_room for the search that was prepared last.
bool TextureSpace::had_room(const SearchCounts &counts, bool anew) {
  CellSet &set = cells();
  if (set.buffers->make_room(counts, anew, gl_->list_texels())) return true;
  set.room = {};
  set.samples.clear();
  return false;
}

// Calls ConnectedTriangles::make_room. Each radius keeps its own room, since several radii may alternate.
bool TextureSpace::floods_had_room(int patches) {
  const bool fits = device_->connected.make_room(patches);
  cells().flood_room = device_->connected.room();
  return fits;
}

// The listed points of the samples; null if samples fetch texels instead.
const BufferTexture *TextureSpace::listed_points(const Job &job) {
  return job.connected() && listed_points_.find(*cells().samples.key()) ? &device_->points : nullptr;
}

// Lists the points of the samples if centers fetch them often: listing a point costs as much as a few fetches.
void TextureSpace::list_points(size_t centers) {
  constexpr size_t worth = 4;
  const CellSet &set = cells();
  const SamplesKey &key = *set.samples.key();
  const size_t fetches = centers * static_cast<size_t>(key.sampling.samples) * 3 / 2; // a neighborhood has up to twice as many
  if (listed_points_.find(key) || fetches <= worth * static_cast<size_t>(set.buffers->room().samples)) return;
  bool listed = false;
  listed_points_.clear();
  gl_->run([&](const Gl &gl, ProgramCache &programs) {
    listed = set.buffers->list_points(gl, programs, *device_->buffer, device_->points);
  });
  if (listed) listed_points_.get(key, [] { return true; });
}

// The wedges sorted by point; begin: (points + 1) the first wedge of each point.
static std::vector<int32_t> wedges_by_point(const Charts &charts, int point_count, std::vector<int32_t> &begin) {
  begin.assign(static_cast<size_t>(point_count) + 1, 0);
  for (const Wedge &wedge : charts.wedges) ++begin[wedge.point + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int32_t> order(charts.wedges.size()), next(begin.begin(), begin.end() - 1);
  for (size_t i = 0; i < order.size(); ++i) order[next[charts.wedges[i].point]++] = static_cast<int32_t>(i);
  return order;
}

// A center starts from all wedges of its point; for seam errors each wedge has to find the others by itself.
static Starts starts_of(const Job &job, const Cells &cells, const Centers &centers) {
  const HalfEdges &half_edges = job.surface.half_edges;
  std::vector<int32_t> begin;
  const std::vector<int32_t> wedges = wedges_by_point(job.charts(), half_edges.point_count, begin);
  std::vector<int32_t> first, list;
  for (size_t i = 0; i < centers.points.size(); ++i) {
    const int32_t point = centers.points[i];
    const bool alone = job.options().seam_error && centers.wedges[i] >= 0;
    const std::span<const int32_t> from = alone ? std::span<const int32_t>(centers.wedges).subspan(i, 1)
                                                : std::span(wedges).subspan(begin[point], begin[point + 1] - begin[point]);
    first.push_back(static_cast<int32_t>(list.size()));
    const auto add = [&](int32_t cell) {
      if (cell >= 0 && std::find(list.begin() + first.back(), list.end(), cell) == list.end()) list.push_back(cell);
    };
    if (centers.wedges[i] < 0) add(cells.triangle_cell[half_edges.point_half_edge[point] / 3]);
    for (const int32_t wedge : from) add(cells.wedge_cell[wedge]);
  }
  first.push_back(static_cast<int32_t>(list.size()));
  return list_starts(first, list, cells.count);
}

// The centers in the order of evaluation: neighboring invocations then have much the same samples, and equally many.
const OrderedCenters &TextureSpace::ordered_centers(const Job &job, const Frame &frame) {
  CellSet &set = cells();
  const pdesc_options &options = job.options();
  const Charts &charts = job.charts();
  return set.centers.get({options.seam_error != 0, options.seed}, [&] {
    OrderedCenters made;
    made.centers = list_centers(charts, center_options(job, frame, 0.0));
    made.starts = starts_of(job, set.cells, made.centers);
    made.centers.permute(made.starts.order);
    for (const int32_t point : made.centers.points) {
      made.vertices.push_back(job.surface.half_edges.point_vertex[point]);
      made.triangles.push_back(job.surface.half_edges.point_half_edge[point] / 3);
    }
    made.version = ++last_version_;
    return made;
  });
}

// The centers on the device. The normal of a center is its point's, or its fan's if the device fits normals.
const PlacedCenters &TextureSpace::placed_centers(const Job &job, const Frame &frame, const OrderedCenters &ordered) {
  CellSet &set = cells();
  const Centers &centers = ordered.centers;
  const bool fits = frame.key.surface.fits_normals;
  const PlacedKey key{ordered.version, fits};
  if (!set.placed.find(key)) gl_->run([&](const Gl &, ProgramCache &) { set.placed.clear(); }); // destroys it on the GL thread
  const auto &kept = set.placed.get(key, [&] {
    const auto groups = fits ? 0 : static_cast<int32_t>(job.surface.normals().group.size());
    std::vector<ivec2> sources;
    for (size_t i = 0; i < centers.points.size(); ++i) {
      const int32_t point = centers.points[i];
      sources.emplace_back(ordered.vertices[i], fits ? job.surface.normals.rings().point_fan[point] : groups + point);
    }
    const std::vector<CenterData> data = describe_centers(job.charts(), center_options(job, frame, 0.0), centers, {});
    std::unique_ptr<PlacedCenters> placed;
    gl_->run([&](const Gl &gl, ProgramCache &) {
      placed.reset(new PlacedCenters{{}, Places(gl, sources)});
      placed->data.upload(gl, data, GL_DYNAMIC_COPY);
      check_gl(gl, "center upload");
    });
    return placed;
  });
  return *kept;
}

} // namespace paradesc
