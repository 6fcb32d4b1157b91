// Surfels → groups of centers → sums → values, pass by pass.
#include "engine/cpu/cpu_engine.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "descriptor/passes.h"
#include "descriptor/registry.h"
#include "engine/cpu/finish.h"
#include "engine/cpu/groups.h"
#include "engine/cpu/search.h"
#include "engine/memory.h"
#include "support/parallel.h"
#include "support/pool.h"

namespace paradesc {

namespace {

class CpuSession final : public Session {
public:
  Computed compute(const Surface &surface, const Request &request, const Resources &resources, const Progress &progress) override;

private:
  std::optional<ClusterTree> tree_;
};

class CpuEngine final : public Engine {
public:
  explicit CpuEngine(int threads) : device_("CPU, " + std::to_string(thread_count(threads)) + " threads") {}
  int32_t backend() const override { return PDESC_BACKEND_CPU; }
  const std::string &device() const override { return device_; }
  Abilities abilities() const override { return {}; }
  std::unique_ptr<Session> open_session() override { return std::make_unique<CpuSession>(); }

private:
  std::string device_;
};

// One pass over all centers.
struct Evaluation {
  const SurfelSource &source;
  const Surfels &surfels;
  const SurfaceSamples &samples;
  const std::vector<TreeCenter> &centers;
  const CenterGroups &groups;
  SumPlan plan;
  EvaluateParams params;
  std::span<const int> rows;
  const std::function<void(double)> &progress; // of this pass; may throw to cancel
};

} // namespace

static int32_t sum_up(const Evaluation &pass, AddSamples add_samples, const Search &search, const SumCenter &center,
                      float *sums) {
  const int32_t nearest = add_samples(pass.params, search.stored(), center, sums);
  const SampleBlocks divided = search.divided();
  if (divided.count == 0) return nearest;
  float more[max_sums] = {};
  const int32_t nearest_of_divided = add_samples(pass.params, divided, center, more);
  for (size_t i = 0; i < max_sums; ++i) sums[i] += more[i];
  return nearest + nearest_of_divided;
}

static void evaluate_group(const Evaluation &pass, AddSamples add_samples, std::span<const int32_t> group, Search &search,
                           CenterResults &results) {
  float sums[max_sums] = {};
  std::vector<float> values;
  search.look(pass.centers, group);
  for (const int32_t index : group) {
    const TreeCenter &center = pass.centers[index];
    const vec3 position = center.position, normal = center.normal;
    const float value = pass.source.map ? (*pass.source.map)[index].w : 0.0f;
    const SumCenter at{{position.x, position.y, position.z}, {normal.x, normal.y, normal.z}, value};
    const int32_t nearest = sum_up(pass, add_samples, search, at, sums);
    const Search::Connected connected = search.find_connected(center, at, nearest);
    if (!connected.all) {
      sum_up(pass, add_samples, search, at, sums);
      search.forget_connected();
    }
    values.clear();
    finish(pass.plan, pass.params, at, sums, connected.boundary, pass.rows, values);
    for (size_t k = 0, next = 0; k < pass.rows.size(); ++k) {
      const auto components = static_cast<size_t>(descriptor_row(pass.rows[k]).components);
      std::copy_n(&values[next], components, &results.values[k][static_cast<size_t>(index) * components]);
      next += components;
    }
    results.boundary[index] = connected.boundary;
  }
}

static CenterResults evaluate(const Evaluation &pass) {
  const size_t count = pass.centers.size();
  CenterResults results = results_at_points(static_cast<int>(count));
  for (const int row : pass.rows)
    results.values.emplace_back(count * static_cast<size_t>(descriptor_row(row).components),
                                std::numeric_limits<float>::quiet_NaN());
  results.boundary.assign(count, 0);
  const SumTarget target = sum_targets()[0];
  const AddSamples add_samples = target.by_kind[static_cast<size_t>(pass.plan.kind)];
  const auto groups = static_cast<int>(pass.groups.begin.size()) - 1;
  std::atomic<int> done{0};
  const CancelScope cancel([&] { pass.progress(static_cast<double>(done) / std::max(groups, 1)); });
  const auto evaluate_one = [&](int g, Search &search) {
    const auto first = static_cast<size_t>(pass.groups.begin[g]), last = static_cast<size_t>(pass.groups.begin[g + 1]);
    evaluate_group(pass, add_samples, std::span(pass.groups.center).subspan(first, last - first), search, results);
    ++done;
  };
  Pool<Search> searches;
  parallel_blocks(groups, pass.source.threads, 8, [&](int begin, int end) {
    searches.with_one([&] { return Search(pass.source, pass.surfels, pass.samples, target.count_nearest); },
                      [&](Search &search) {
                        for (int g = begin; g < end; ++g) evaluate_one(g, search);
                      });
  });
  return results;
}

static std::vector<TreeCenter> centers_at_points(const Surface &surface, const BakeSpace &space) {
  std::vector<TreeCenter> centers(static_cast<size_t>(surface.half_edges.point_count));
  for (size_t i = 0; i < centers.size(); ++i)
    centers[i] = {space.to_buffer(surface.triangles.positions[surface.half_edges.point_vertex[i]]), surface.normals.point[i],
                  surface.half_edges.point_half_edge[i] / 3};
  return centers;
}

// To the units of the positions.
static void scale_values(std::span<const int> rows, double scale, CenterResults &results) {
  for (size_t k = 0; k < rows.size(); ++k) {
    const auto unit = static_cast<float>(std::pow(scale, -descriptor_row(rows[k]).length_power));
    if (unit == 1.0f) continue;
    for (float &value : results.values[k]) value *= unit;
  }
}

static float share_of_clusters(const Surfels &surfels) {
  double clusters = 0, all = 0;
  for (size_t k = 0; k < surfels.surfel.size(); ++k) {
    const double triangles = surfels.first[k + 1] - surfels.first[k];
    all += triangles;
    if (surfels.surfel[k].level > 0) clusters += triangles;
  }
  return all > 0 ? static_cast<float>(clusters / all) : 0.0f;
}

// share_of_clusters: of the triangles. The rim cuts triangles exactly: only what clusters leave is noise to be reduced.
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

// Half of the radius has as many samples as the radius, where both count.
static int samples_of_both_radii(const Pass &pass, const pdesc_options &options) {
  const bool two_radii =
      options.estimator == PDESC_ESTIMATOR_EXTRAPOLATED && pass.stage != Stage::map && pass.stage != Stage::windows;
  return samples_of(pass, options) * (two_radii ? 4 : 1);
}

Computed CpuSession::compute(const Surface &surface, const Request &request, const Resources &resources,
                             const Progress &progress) {
  const pdesc_options &options = request.options;
  Clock clock;
  if (!tree_) tree_ = build_cluster_tree(surface.half_edges);
  const BakeSpace space = bake_space_of(surface.extent.box);
  const std::vector<TreeCenter> centers = centers_at_points(surface, space);
  Computed computed;
  computed.report.seconds_prepare = clock.lap();
  const auto run = [&](const Pass &pass, const MapValues *map, int number, int count) {
    const std::function<void(double)> part = [&](double done) { check_cancel(progress, "evaluate", (number + done) / count); };
    part(0.0);
    const auto radius = static_cast<float>(radius_of(pass, options, request.radius) * space.scale);
    const SurfelSource source{surface.triangles, surface.half_edges, surface.normals, *tree_, space, map, resources.threads};
    const Surfels surfels = build_surfels(source, radius, samples_of_both_radii(pass, options));
    const SurfaceSamples samples = list_samples(source, surfels);
    const CenterGroups groups = group_centers(*tree_, centers, radius);
    CenterResults results =
        evaluate({source, surfels, samples, centers, groups, plan_sums(pass.rows, options, pass.stage == Stage::windows),
                  params_of(request, space.scale, radius, share_of_clusters(surfels)), pass.rows, part});
    scale_values(pass.rows, space.scale, results);
    return results;
  };
  computed.results = run_passes(surface.half_edges.point_count, request.descriptors, find_map(options.map_descriptor), run);
  check_cancel(progress, "evaluate", 1.0);
  computed.report.places = surface.half_edges.point_count;
  computed.report.refined_share = 1.0;
  computed.report.seconds_evaluate = clock.lap();
  return computed;
}

std::shared_ptr<Engine> open_cpu_engine(int threads) { return std::make_shared<CpuEngine>(threads); }

MemoryForecast forecast_cpu_memory(const ComputationSize &size) {
  // The tree, and while it is cut for a radius: clusters, counts, surfels, cells.
  constexpr int64_t of_triangle = 24 + 2 * (sizeof(Surfel) + 32) + sizeof(Surfel) + 40;
  // In parts, and as one list that grows by half.
  constexpr int64_t of_sample = (5 * static_cast<int64_t>(SURFACE_ROWS * sizeof(float))) / 2;
  const auto triangles = static_cast<double>(size.triangles);
  const double divided = std::min(1.5 * size.options.samples * size.disks, triangles * static_cast<double>(max_stored_samples));
  MemoryForecast memory;
  memory.host = bytes_of_results(size) + size.triangles * of_triangle + static_cast<int64_t>(triangles + divided) * of_sample;
  return memory;
}

} // namespace paradesc
