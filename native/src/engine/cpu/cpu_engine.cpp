// Passes over a surface → values at points and texels, with values blended at creases.
#include "engine/cpu/cpu_engine.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "descriptor/passes.h"
#include "descriptor/registry.h"
#include "engine/cpu/center_values.h"
#include "engine/cpu/centers.h"
#include "engine/cpu/summed_surface.h"
#include "engine/creases/blend.h"
#include "engine/memory.h"
#include "support/keyed.h"
#include "support/parallel.h"

namespace paradesc {

namespace {

// One pass, with values blended at creases.
class RunningPass {
public:
  RunningPass(const PassInputs &of, SummedMesh &kept)
      : of_(of), summed_(of, kept), creases_(of.surface, of.pass.rows, of.radius(), of.resources.threads) {}

  // Evaluates the first `count` points.
  CenterResults at_points(std::span<const int> rows, int32_t count, const std::function<void(double)> &progress) const {
    CenterResults results = at(centers_at_points(of_.surface, of_.space, count, of_.resources.threads),
                               of_.map ? *of_.map : MapValues(), rows, progress);
    creases_.at_points(rows, results, progress);
    return results;
  }

  // Evaluates the texels [first, last).
  CenterResults at_texels(const TexelMap &texels, size_t first, size_t last, std::span<const int> rows,
                          const std::function<void(double)> &progress) const {
    MapValues map;
    if (of_.map) map = map_at_texels(of_.surface, texels, *of_.map, first, last, of_.resources.threads);
    CenterResults results =
        at(centers_at_texels(of_.surface, of_.space, texels, first, last, of_.resources.threads), map, rows, progress);
    creases_.at_texels(rows, texels, first, results, progress);
    return results;
  }

private:
  CenterResults at(const TreeCenters &centers, const MapValues &map, std::span<const int> rows,
                   const std::function<void(double)> &progress) const {
    CenterResults results = summed_.at(centers, map, rows, creases_.before(progress));
    scale_values(rows, of_.space.scale, results);
    return results;
  }

  const PassInputs &of_;
  SummedSurface summed_;
  CreaseBlend creases_;
};

class CpuSession final : public Session {
public:
  Computed compute(const Surface &surface, const Request &request, const Resources &resources, const Progress &progress) override;

private:
  const TexelMap &texels(const Surface &surface, int size, int threads);

  SummedMesh summed_;
  Keyed<std::pair<int, int>, TexelMap> texels_; // by the atlas's version and the size
};

class CpuEngine final : public Engine {
public:
  explicit CpuEngine(int threads) : device_("CPU, " + std::to_string(thread_count(threads)) + " threads") {}
  int32_t backend() const override { return PDESC_BACKEND_CPU; }
  const std::string &device() const override { return device_; }
  Abilities abilities() const override { return {.texels = true}; }
  std::unique_ptr<Session> open_session() override { return std::make_unique<CpuSession>(); }

private:
  std::string device_;
};

} // namespace

static constexpr size_t texels_of_band = size_t{1} << 17; // texels that are evaluated together

// Returns whether a pass over the surface computes the map with exactly the same bits as the map's own pass.
static bool computes_map(const Pass &pass, int map_row, const pdesc_options &options) {
  const Pass source{Stage::source, {map_row}};
  return pass.stage == Stage::surface && std::ranges::find(pass.rows, map_row) != pass.rows.end() &&
         fineness_of(pass, options) == fineness_of(source, options) &&
         plan_sums(pass.rows, options, false) == plan_sums(source.rows, options, false);
}

// Returns the values at points that later passes read from the map. The values of other rows stay empty.
static CenterResults values_for_map(const RunningPass &running, const Pass &pass, int points,
                                    const std::function<void(double)> &progress) {
  CenterResults results = results_at_points(points);
  results.values.resize(pass.rows.size());
  for (size_t i = 0; i < pass.rows.size(); ++i)
    if (pass.stage == Stage::source || pass.rows[i] == gradient_row())
      results.values[i] = std::move(running.at_points(std::span(&pass.rows[i], 1), points, progress).values[0]);
  return results;
}

// Computes a pass at texels, band by band, and adds it to the results.
static void add_texels(const RunningPass &running, const Pass &pass, std::span<const int> requested, const TexelMap &texels,
                       const std::function<void(double)> &progress, CenterResults &all) {
  std::vector<int> rows;
  std::vector<size_t> places; // indices in `requested`
  for (size_t k = 0; k < requested.size(); ++k)
    if (pass.stage != Stage::source && std::ranges::find(pass.rows, requested[k]) != pass.rows.end()) {
      rows.push_back(requested[k]);
      places.push_back(k);
    }
  const size_t count = rows.empty() ? 0 : texels.centers.size();
  for (size_t first = 0, last = 0; first < count; first = last) {
    last = std::min(first + texels_of_band, count);
    const std::function<void(double)> part = [&](double done) {
      progress((static_cast<double>(first) + done * static_cast<double>(last - first)) / static_cast<double>(count));
    };
    const CenterResults found = running.at_texels(texels, first, last, rows, part);
    for (size_t i = 0; i < rows.size(); ++i) {
      const size_t width = found.values[i].size() / (last - first);
      std::ranges::copy(found.values[i], all.values[places[i]].begin() + static_cast<ptrdiff_t>(first * width));
    }
    std::ranges::copy(found.boundary, all.boundary.begin() + static_cast<ptrdiff_t>(first));
  }
}

const TexelMap &CpuSession::texels(const Surface &surface, int size, int threads) {
  const auto key = [&] { return std::pair(surface.atlases.current().version, size); };
  if (const TexelMap *const kept = texels_.find(key())) return *kept;
  texels_.clear();
  TexelMap made = lay_out_texels(surface, size, threads); // may replace the atlas
  return texels_.get(key(), [&] { return std::move(made); });
}

// Fills in the images, and the values at vertices that are looked up in them.
static void give_texels(const Surface &surface, const Request &request, const Resources &resources, const TexelMap &texels,
                        const CenterResults &results, Computed &computed) {
  const Atlas &atlas = surface.atlases.current();
  computed.results = look_up(texels, results, atlas.charts, false, resources.threads);
  computed.images = images_of(texels, results, request.descriptors);
  computed.image_size = texels.size;
  computed.report.places = static_cast<int32_t>(texels.centers.size());
  computed.report.private_layout = atlas.layout;
  computed.report.cut_charts = atlas.cut_charts;
}

// A map that later passes read is needed on the whole surface.
static int32_t points_of(const Pass &pass, const Surface &surface) {
  return pass.makes_map() ? surface.half_edges.point_count : surface.wanted_points();
}

Computed CpuSession::compute(const Surface &surface, const Request &request, const Resources &resources,
                             const Progress &progress) {
  const pdesc_options &options = request.options;
  Clock clock;
  const BakeSpace space = bake_space_of(surface.box);
  const TexelMap *map_texels = nullptr;
  CenterResults at_texels;
  if (options.evaluate == PDESC_EVALUATE_TEXEL) {
    map_texels = &texels(surface, options.texels, resources.threads);
    at_texels = unknown_results(map_texels->centers.size(), request.descriptors);
  }
  Computed computed;
  computed.report.seconds_prepare = clock.lap();
  const int map_row = find_map(options.map_descriptor);
  std::vector<float> of_map; // values at points, if they are known before the map's own pass
  const auto run = [&](const Pass &pass, const MapValues *map, int number, int count) {
    const std::function<void(double)> part = [&](double done) { check_cancel(progress, "evaluate", (number + done) / count); };
    part(0.0);
    if (pass.stage == Stage::source && !of_map.empty()) {
      CenterResults results = results_at_points(surface.half_edges.point_count);
      results.values = {std::move(of_map)};
      return results;
    }
    const PassInputs inputs{surface, request, space, pass, map, resources};
    const RunningPass running = [&] {
      const CancelScope cancel([&] { part(0.0); });
      return RunningPass(inputs, summed_);
    }();
    if (!map_texels) {
      const int32_t points = points_of(pass, surface);
      CenterResults results = running.at_points(pass.rows, points, part);
      if (points == surface.half_edges.point_count && computes_map(pass, map_row, options))
        of_map = results.values[std::ranges::find(pass.rows, map_row) - pass.rows.begin()];
      return results;
    }
    constexpr double share = 0.7; // of the progress: texels, before the points are evaluated
    const std::function<void(double)> first = [&](double done) { part(share * done); };
    const std::function<void(double)> second = [&](double done) { part(share + (1.0 - share) * done); };
    add_texels(running, pass, request.descriptors, *map_texels, first, at_texels);
    return values_for_map(running, pass, surface.half_edges.point_count, second);
  };
  computed.results = run_passes(surface.half_edges.point_count, request.descriptors, map_row, run);
  keep_centers(computed.results, static_cast<size_t>(surface.wanted_points()), request.descriptors);
  computed.report.places = surface.wanted_points();
  if (map_texels) give_texels(surface, request, resources, *map_texels, at_texels, computed);
  check_cancel(progress, "evaluate", 1.0);
  computed.report.refined_share = 1.0;
  computed.report.seconds_evaluate = clock.lap();
  return computed;
}

std::shared_ptr<Engine> open_cpu_engine(int threads) { return std::make_shared<CpuEngine>(threads); }

// The memory for texels: centers in their first order and in that of the texels, results and images, and one band with the map's
// values at points.
static int64_t bytes_of_texels(const ComputationSize &size) {
  const int64_t texels = int64_t{size.options.texels} * size.options.texels, rows = rows_of(size.descriptors);
  const int64_t band = std::min<int64_t>(texels, texels_of_band) + size.piece_points;
  return texels * static_cast<int64_t>(4 + 2 * sizeof(TexelCenter)) + texels * 8 * rows +
         band * static_cast<int64_t>(sizeof(TreeCenter) + sizeof(vec4) + 16 + 8 * rows);
}

// The memory for the order of points, patches and their surface, and for what is used while they are made.
static int64_t bytes_of_patches(const ComputationSize &size) {
  constexpr int64_t of_triangle = 48 + sizeof(RimTriangle) + sizeof(MomentRow) + 10, of_point = 340;
  constexpr int64_t of_thread = 12; // for each point
  return size.pieces * of_triangle + size.piece_points * (of_point + size.threads * of_thread);
}

MemoryForecast forecast_cpu_memory(const ComputationSize &size) {
  const Pass finest{Stage::surface, {size.descriptors.begin(), size.descriptors.end()}};
  const auto triangles = static_cast<double>(size.pieces);
  const double divided =
      std::min(1.5 * fineness_of(finest, size.options).samples * size.disks, triangles * static_cast<double>(max_stored_samples));
  const double listed = plan_sums(finest.rows, size.options, false).kind == SumKind::fit ? 0.0 : triangles;
  MemoryForecast memory;
  memory.host = bytes_of_results(size) + bytes_of_patches(size) + static_cast<int64_t>(listed + divided) * bytes_of_sample;
  if (size.options.evaluate == PDESC_EVALUATE_TEXEL) memory.host += bytes_of_texels(size);
  return memory;
}

} // namespace paradesc
