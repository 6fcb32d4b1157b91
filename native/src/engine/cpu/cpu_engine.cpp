// Surfels → groups of centers → sums → values, one pass at a time.
#include "engine/cpu/cpu_engine.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "descriptor/passes.h"
#include "descriptor/registry.h"
#include "engine/cpu/center_values.h"
#include "engine/cpu/centers.h"
#include "engine/cpu/exact_choice.h"
#include "engine/cpu/exact_pass.h"
#include "engine/cpu/finish.h"
#include "engine/cpu/groups.h"
#include "engine/cpu/search.h"
#include "engine/creases/blend.h"
#include "engine/memory.h"
#include "support/keyed.h"
#include "support/parallel.h"
#include "support/pool.h"

namespace paradesc {

namespace {

class CpuSession final : public Session {
public:
  Computed compute(const Surface &surface, const Request &request, const Resources &resources, const Progress &progress) override;

private:
  const TexelMap &texels(const Surface &surface, int size, int threads);
  const ClusterTree &tree(const Surface &surface) {
    return tree_.get(surface.topology_version, [&] { return build_cluster_tree(surface.half_edges); });
  }
  const PointPatches &patches(const Surface &surface) {
    return patches_.get(surface.topology_version, [&] { return build_point_patches(surface.half_edges); });
  }

  void refit(const Surface &surface, const Request &request, const BakeSpace &space, int threads) {
    patch_surface_.refit(patches(surface), surface.triangles, surface.half_edges, surface.normals(), space, ball_targets()[0],
                         asks_for_noise(request.descriptors), threads);
  }

  Keyed<uint64_t, ClusterTree> tree_;           // by the topology's version
  Keyed<uint64_t, PointPatches> patches_;       // by the topology's version
  PatchSurface patch_surface_;                  // of the last surface with these patches
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

// One pass over all centers.
struct Evaluation {
  const SurfelSource &source;
  const Surfels &surfels;
  const SurfaceSamples &samples;
  const TreeCenters &centers;
  const MapValues &map; // (centers) values of the map for operators; or empty
  CenterGroups groups;
  SumPlan plan;
  EvaluateParams params;
  std::span<const int> rows;
  const std::function<void(double)> &progress; // called with the share of this pass that is done; may throw to cancel
};

} // namespace

static SumCenter sum_center(const Evaluation &pass, size_t index) {
  const TreeCenter &center = pass.centers[index];
  SumCenter to;
  for (int axis = 0; axis < 3; ++axis) {
    to.position[axis] = center.position[axis];
    to.normal[axis] = center.normal[axis];
  }
  to.value = pass.map.empty() ? 0.0f : pass.map[index].w;
  return to;
}

static void evaluate_group(const Evaluation &pass, const SumTarget &target, std::span<const int32_t> group, Search &search,
                           CenterResults &results) {
  search.look(pass.centers, group);
  float sums[max_sums] = {};
  std::vector<float> values;
  search.find_each(pass.centers, group, [&](int32_t i, const Search::Found &found) {
    const auto index = static_cast<size_t>(i);
    const SumCenter center = sum_center(pass, index);
    target.by_kind[static_cast<size_t>(pass.plan.kind)](pass.params, found.samples, center, sums);
    results.boundary[index] = found.boundary;
    values.clear();
    finish(pass.plan, pass.params, center, sums, found.boundary, pass.rows, values);
    for (size_t k = 0, next = 0; k < pass.rows.size(); ++k) {
      const auto components = static_cast<size_t>(descriptor_row(pass.rows[k]).components);
      std::copy_n(&values[next], components, &results.values[k][index * components]);
      next += components;
    }
  });
}

static CenterResults evaluate(const Evaluation &pass) {
  const size_t count = pass.centers.size();
  CenterResults results = unknown_results(count, pass.rows);
  const SumTarget target = sum_targets()[0];
  const auto groups = static_cast<int>(pass.groups.begin.size()) - 1;
  std::atomic<int> done{0};
  const CancelScope cancel([&] { pass.progress(static_cast<double>(done) / std::max(groups, 1)); });
  const auto evaluate_one = [&](int g, Search &search) {
    const auto first = static_cast<size_t>(pass.groups.begin[g]), last = static_cast<size_t>(pass.groups.begin[g + 1]);
    checkpoint(); // One group alone may take milliseconds.
    evaluate_group(pass, target, std::span(pass.groups.center).subspan(first, last - first), search, results);
    ++done;
  };
  Pool<Search> searches;
  parallel_blocks(groups, pass.source.threads, 8, [&](int begin, int end) {
    searches.with_one([&] { return Search(pass.source, pass.surfels, pass.samples, target, adds_blocks(pass.plan.kind)); },
                      [&](Search &search) {
                        for (int g = begin; g < end; ++g) evaluate_one(g, search);
                      });
  });
  return results;
}

static float share_of_clusters(const Surfels &surfels) {
  double clusters = 0, all = 0;
  for (size_t k = 0; k < surfels.surfel.size(); ++k) {
    const double triangles = surfels.first[k + 1] - surfels.first[k];
    all += triangles;
    if (surfels.surfel[k].cluster >= 0) clusters += triangles;
  }
  return all > 0 ? static_cast<float>(clusters / all) : 0.0f;
}

// share_of_clusters: share of the triangles. The rim cuts triangles exactly, so only clusters leave noise to be reduced.
static EvaluateParams params_of(const Request &request, double scale, float radius, float share_of_clusters) {
  const pdesc_options &options = request.options;
  EvaluateParams params{};
  params.radius = radius;
  if (options.variance_reduction != PDESC_VARIANCE_REDUCTION_NONE) params.variate_share = share_of_clusters;
  params.map_radius = static_cast<float>(request.radius * scale);
  params.map_sigma = static_cast<float>(options.map_sigma) * params.map_radius;
  params.harris_k = static_cast<float>(options.harris_k);
  return params;
}

// Returns the resolution that a pass needs. Areas are cut off sharply at the rim, where the errors of clusters do not average
// out. They need five times as many samples, and triangles half as large. Extrapolation also uses half of the radius, which then
// has as many samples as the radius otherwise. Bending is dominated by the surface near the center, and needs half as many
// samples again. Curvature hardly depends on the size of triangles, or on the details within a cluster.
static Fineness fineness_of(const Pass &pass, const pdesc_options &options) {
  const auto any = [&](std::string_view terms) {
    return std::ranges::any_of(pass.rows, [&](int row) { return uses_terms(row, terms); });
  };
  if (pass.stage != Stage::surface && pass.stage != Stage::source) return {options.samples};
  if (options.estimator == PDESC_ESTIMATOR_EXTRAPOLATED) return {4 * options.samples};
  constexpr float half_as_large = 3.0f, large = 5.0f, coherence_for_curvature = 0.95f;
  if (options.estimator == PDESC_ESTIMATOR_INTEGRAL || any("area")) return {5 * options.samples, half_as_large};
  if (any("bending")) return {3 * options.samples / 2};
  if (pass.stage == Stage::source) return {options.samples};
  return any("ball") ? Fineness{options.samples, large} : Fineness{options.samples, large, coherence_for_curvature};
}

// Samples are stored in growing parts and in one list.
static constexpr int64_t bytes_of_sample = (5 * static_cast<int64_t>(sizeof(FlatSample))) / 2;

// Throws if the samples do not fit. The mesh's counts cannot predict this, since maps may displace a surface arbitrarily far.
static SurfaceSamples samples_within(int64_t memory_limit, const SurfelSource &source, const Surfels &surfels) {
  double count = 0.0;
  for (const Surfel &surfel : surfels.surfel)
    if (surfel.samples <= max_stored_samples) count += surfel.samples;
  const int64_t of_sample = bytes_of_sample + (source.map ? 2 * static_cast<int64_t>(sizeof(SampleMap)) : 0);
  check_memory(memory_limit, "A surface that about " + std::to_string(std::llround(count)) + " samples stand for",
               "use a larger radius, fewer samples, or maps that displace less", std::llround(count) * of_sample, 0);
  return list_samples(source, surfels);
}

namespace {

// One pass on a surface that is divided for it.
class RunningPass {
public:
  RunningPass(const Surface &surface, const Request &request, const ClusterTree &tree, const BakeSpace &space, const Pass &pass,
              const MapValues *map, const Resources &resources)
      : surface_(surface), request_(request), pass_(pass),
        radius_(static_cast<float>(radius_of(pass, request.options, request.radius) * space.scale)),
        space_(space), source_{surface.triangles,
                               surface.half_edges,
                               surface.normals(),
                               tree,
                               positions_in(space, surface.triangles, resources.threads),
                               map,
                               resources.threads,
                               static_cast<float>(space.scale)},
        surfels_(build_surfels(source_, radius_, fineness_of(pass, request.options))),
        samples_(samples_within(resources.memory_limit, source_, surfels_)),
        params_(params_of(request, space.scale, radius_, share_of_clusters(surfels_))),
        creases_(surface, pass.rows, radius_of(pass, request.options, request.radius), resources.threads) {
    surfels_.cluster = {}; // The samples replace them.
  }

  // Evaluates the first `count` points.
  CenterResults at_points(std::span<const int> rows, int32_t count, const std::function<void(double)> &progress) const {
    CenterResults results =
        at(centers_at_points(surface_, space_, count, source_.threads), source_.map ? *source_.map : MapValues(), rows,
           creases_.before(progress));
    creases_.at_points(rows, results, progress);
    return results;
  }

  // Evaluates the texels [first, last).
  CenterResults at_texels(const TexelMap &texels, size_t first, size_t last, std::span<const int> rows,
                          const std::function<void(double)> &progress) const {
    MapValues map;
    if (source_.map) map = map_at_texels(surface_, texels, *source_.map, first, last, source_.threads);
    CenterResults results =
        at(centers_at_texels(surface_, space_, texels, first, last, source_.threads), map, rows, creases_.before(progress));
    creases_.at_texels(rows, texels, first, results, progress);
    return results;
  }

private:
  // map: values at the centers, if there is a map.
  CenterResults at(const TreeCenters &centers, const MapValues &map, std::span<const int> rows,
                   const std::function<void(double)> &progress) const {
    CenterResults results = evaluate({source_, surfels_, samples_, centers, map, group_centers(source_.tree, centers, radius_),
                                      plan_sums(rows, request_.options, pass_.stage == Stage::windows), params_, rows, progress});
    scale_values(rows, space_.scale, results);
    return results;
  }

  const Surface &surface_;
  const Request &request_;
  const Pass &pass_;
  float radius_;
  const BakeSpace &space_;
  SurfelSource source_;
  Surfels surfels_;
  SurfaceSamples samples_;
  EvaluateParams params_;
  CreaseBlend creases_;
};

} // namespace

static CenterResults run_exactly(const Surface &surface, const Request &request, const BakeSpace &space, const Pass &pass,
                                 const PointPatches &patches, const PatchSurface &patch_surface, const Resources &resources,
                                 const std::function<void(double)> &progress) {
  const double radius = radius_of(pass, request.options, request.radius);
  const CreaseBlend creases(surface, pass.rows, radius, resources.threads);
  CenterResults results = unknown_results(static_cast<size_t>(surface.half_edges.point_count), pass.rows);
  evaluate_exactly({patches, patch_surface, ball_targets()[0], plan_sums(pass.rows, request.options, false),
                    params_of(request, space.scale, static_cast<float>(radius * space.scale), 0.0f), pass.rows, resources.threads,
                    creases.before(progress)},
                   results);
  scale_values(pass.rows, space.scale, results);
  creases.at_points(pass.rows, results, progress);
  return results;
}

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
  std::optional<TriangleSizes> sizes;
  bool refitted = false;     // whether patch_surface_ holds this surface
  std::vector<float> of_map; // values at points, if they are known before the map's own pass
  const auto run = [&](const Pass &pass, const MapValues *map, int number, int count) {
    const std::function<void(double)> part = [&](double done) { check_cancel(progress, "evaluate", (number + done) / count); };
    part(0.0);
    if (pass.stage == Stage::source && !of_map.empty()) {
      CenterResults results = results_at_points(surface.half_edges.point_count);
      results.values = {std::move(of_map)};
      return results;
    }
    if (has_exact_sums(surface, request, pass)) {
      const CancelScope cancel([&] { part(0.0); });
      if (!sizes) sizes = measure_triangles(surface.triangles, surface.half_edges, resources.threads);
      if (suits_exact_sums(*sizes, radius_of(pass, options, request.radius))) {
        if (!std::exchange(refitted, true)) refit(surface, request, space, resources.threads);
        return run_exactly(surface, request, space, pass, patches(surface), patch_surface_, resources, part);
      }
    }
    if (!refitted) patch_surface_ = {}; // Frees memory that the samples need.
    const RunningPass running = [&] {
      const CancelScope cancel([&] { part(0.0); });
      return RunningPass(surface, request, tree(surface), space, pass, map, resources);
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

// The memory for the patches and their surface, which stays allocated between frames, and for neighbors during construction.
static int64_t bytes_of_exact_sums(const ComputationSize &size) {
  constexpr int64_t of_triangle = 36 + sizeof(RimTriangle) + sizeof(MomentRow) + 10, of_point = 260;
  constexpr int64_t of_thread = 12; // for each point
  return size.triangles * of_triangle + size.points * (of_point + size.threads * of_thread);
}

MemoryForecast forecast_cpu_memory(const ComputationSize &size) {
  // Tree, positions, faces and places; sizes, counts and places of clusters while surfels are built; links.
  constexpr int64_t of_triangle = 12 + 40 + 120 + sizeof(Surfel) + 44;
  constexpr int64_t of_thread = 12; // for each surfel, of which there are at most as many as triangles: Search, GroupFlood
  const auto triangles = static_cast<double>(size.pieces);
  const Pass finest{Stage::surface, {size.descriptors.begin(), size.descriptors.end()}};
  const double divided =
      std::min(1.5 * fineness_of(finest, size.options).samples * size.disks, triangles * static_cast<double>(max_stored_samples));
  MemoryForecast memory;
  const int64_t of_samples =
      size.pieces * (of_triangle + size.threads * of_thread) + static_cast<int64_t>(triangles + divided) * bytes_of_sample;
  memory.host = bytes_of_results(size) + std::max(of_samples, bytes_of_exact_sums(size));
  if (size.options.evaluate == PDESC_EVALUATE_TEXEL) memory.host += bytes_of_texels(size);
  return memory;
}

} // namespace paradesc
