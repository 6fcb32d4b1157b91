// Nodes → patches → samples → groups of centers → values.
#include "engine/cpu/summed_surface.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "descriptor/registry.h"
#include "engine/cpu/exact_pass.h"
#include "engine/cpu/point_clusters.h"
#include "engine/memory.h"
#include "support/parallel.h"
#include "support/targets.h"

namespace paradesc {

PARADESC_TARGETS(SumTarget, sums_of, sum_targets)
PARADESC_TARGETS(BallTarget, ball_sums_of, ball_targets)

static constexpr int points_of_block = 4096;

// Returns the resolution that a pass needs. Areas are cut off sharply at the rim, and need triangles half as large. Gaussian
// curvature by areas magnifies their errors, and needs five times as many samples. Extrapolation also uses half of the radius,
// which then has as many samples as the radius otherwise. Curvature and volumes hardly depend on the size of triangles.
Fineness fineness_of(const Pass &pass, const pdesc_options &options) {
  const auto any = [&](std::string_view terms) {
    return std::ranges::any_of(pass.rows, [&](int row) { return uses_terms(row, terms); });
  };
  if (pass.stage != Stage::surface && pass.stage != Stage::source) return {options.samples};
  if (options.estimator == PDESC_ESTIMATOR_EXTRAPOLATED) return {4 * options.samples};
  constexpr float half_as_large = 3.0f, large = 5.0f;
  if (options.estimator == PDESC_ESTIMATOR_INTEGRAL) return {5 * options.samples, half_as_large};
  if (any("area")) return {options.samples, half_as_large};
  if (pass.stage == Stage::source || any("bending")) return {options.samples};
  return {options.samples, large};
}

static SumPlan plan_of(const PassInputs &of, std::span<const int> rows) {
  return plan_sums(rows, of.request.options, of.pass.stage == Stage::windows);
}

static bool has_moments(const PassInputs &of) { return plan_of(of, of.pass.rows).kind == SumKind::fit; }

// Returns the largest spread of a sample. Operators read a map, whose derivatives magnify what samples leave out.
static float largest_spread(const PassInputs &of) {
  constexpr float least = 1e-13f;                      // floats cannot resolve smaller pieces
  constexpr float without_map = 2.0f, with_map = 1.0f; // relative to the squared radius over the number of samples
  const auto samples = static_cast<float>(fineness_of(of.pass, of.request.options).samples);
  return std::max((of.map ? with_map : without_map) * of.scaled_radius() * of.scaled_radius() / samples, least);
}

static SampleLimit limit_of(const PassInputs &of) {
  return {fineness_of(of.pass, of.request.options).triangles * largest_spread(of)};
}

static EvaluateParams params_of(const PassInputs &of) {
  const pdesc_options &options = of.request.options;
  EvaluateParams params{};
  params.radius = of.scaled_radius();
  params.map_radius = static_cast<float>(of.request.radius * of.space.scale);
  params.map_sigma = static_cast<float>(options.map_sigma) * params.map_radius;
  params.harris_k = static_cast<float>(options.harris_k);
  return params;
}

// Throws if so many samples do not fit. The mesh's counts cannot predict this, since maps may displace a surface arbitrarily far.
static void check_samples(const PassInputs &of, double count) {
  const int64_t of_sample = bytes_of_sample + (of.map ? static_cast<int64_t>(sizeof(SampleMap)) : 0);
  check_memory(of.resources.memory_limit, "A surface that about " + std::to_string(std::llround(count)) + " samples stand for",
               "use a larger radius, fewer samples, or maps that displace less", std::llround(count) * of_sample,
               of.resources.memory_held);
}

// Returns the mean unit normals of the faces around each point, weighted by area.
static std::vector<vec3> facing_of(const PassInputs &of) {
  const HalfEdges &half_edges = of.surface.half_edges;
  std::vector<vec3> facing(static_cast<size_t>(half_edges.point_count));
  parallel_blocks(half_edges.point_count, of.resources.threads, points_of_block, [&](int begin, int end) {
    for (int point = begin; point < end; ++point) {
      vec3 sum(0.0f);
      float area = 0.0f;
      for_each_corner_around(half_edges, point, [&](int32_t corner) {
        const int32_t t = corner / 3;
        const vec3 a = of.surface.triangles.position(3 * t);
        const vec3 plane = cross(of.surface.triangles.position(3 * t + 1) - a, of.surface.triangles.position(3 * t + 2) - a);
        sum += plane;
        area += length(plane);
      });
      facing[point] = area > 0.0f ? sum / area : vec3(0.0f);
    }
  });
  return facing;
}

static std::vector<int32_t> plan_nodes(const PassInputs &of, const PointOrder &order) {
  const HalfEdges &half_edges = of.surface.half_edges;
  std::vector<vec3> positions(static_cast<size_t>(half_edges.point_count));
  parallel_blocks(half_edges.point_count, of.resources.threads, points_of_block, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      positions[i] = of.space.to_buffer(of.surface.triangles.positions[half_edges.point_vertex[i]]);
  });
  // Normals agree to 2.6 degrees, so that a cluster hides no detail, unless fewer samples than by default ask for less.
  constexpr float apart = 0.002f, usual = 256.0f;
  const auto samples = static_cast<float>(fineness_of(of.pass, of.request.options).samples);
  const ClusterLimit limit{largest_spread(of), 1.0f - apart * std::max(usual / samples, 1.0f)};
  PointSurface surface{positions, of.surface.normals().point, {}};
  std::vector<vec3> facing;
  if (!has_moments(of)) {
    facing = facing_of(of);
    surface.facing = facing;
  }
  return plan_nodes(order, surface, limit, of.resources.threads);
}

// Throws if so many nodes do not fit. A smooth surface has far fewer than points.
static void check_nodes(const PassInputs &of, size_t nodes) {
  const auto count = static_cast<int64_t>(nodes);
  const int64_t triangles = std::min<int64_t>(of.surface.triangles.triangle_count, 2 * count); // Euler: two for each node
  check_memory(of.resources.memory_limit,
               "A surface so rough that about " + std::to_string(triangles) + " triangles are summed one by one",
               "use fewer triangles", bytes_of_patches(triangles, count, of.resources.threads), of.resources.memory_held);
}

static const PointPatches &patches_of(const PassInputs &of, const PointOrder &order, SummedMesh &kept) {
  const std::pair key(of.surface.topology_version, plan_nodes(of, order));
  return kept.patches.get(key, [&] {
    check_nodes(of, key.second.size());
    return build_point_patches(order, of.surface.half_edges, key.second, of.resources.threads);
  });
}

static const PatchSurface &refit(const PassInputs &of, const PatchSurface::Mesh &mesh, const PointPatches &patches,
                                 PatchSurface &surface) {
  // A ball reaches beyond an edge with both ends outside by an eighth of its squared length over the radius. Moments leave that
  // out; areas need it.
  const float large = has_moments(of) ? 1.0f : 0.35f; // of the radius
  surface.refit(patches, mesh, ball_targets()[0], {large * of.scaled_radius(), has_moments(of), asks_for_noise(of.pass.rows)},
                of.resources.threads);
  return surface;
}

SummedSurface::SummedSurface(const PassInputs &of, SummedMesh &kept)
    : of_(of), mesh_{of.surface.triangles, of.surface.half_edges, of.surface.normals(), of.space},
      order_(kept.order.get(of.surface.topology_version, [&] { return order_points(of.surface.half_edges); })),
      patches_(patches_of(of, order_, kept)), sampled_{patches_, refit(of, mesh_, patches_, kept.surface), mesh_, of.map,
                                                       of.resources.threads},
      limit_(limit_of(of)), params_(params_of(of)) {
  const SampledTriangles which = has_moments(of) ? SampledTriangles::large : SampledTriangles::all;
  check_samples(of, count_samples(sampled_, limit_, which));
  samples_ = list_samples(sampled_, limit_, which);
}

CenterResults SummedSurface::at(const CenterPoints &centers, const MapValues &map, std::span<const int> rows,
                                const std::function<void(double)> &progress) const {
  CenterResults results = unknown_results(centers.size(), rows);
  const bool are_points = centers.size() == order_.tree.item.size() && (centers.empty() || centers[0].point >= 0);
  const CenterGroups groups = are_points ? fit_groups({order_.tree.item, order_.group_begin}, centers, of_.scaled_radius())
                                         : group_centers(patches_.node_of_triangle, centers, of_.scaled_radius(), group_lanes);
  evaluate_exactly({patches_, sampled_.surface, samples_, sampled_, limit_, centers, groups,
                    of_.surface.half_edges.triangle_piece, map, ball_targets()[0], sum_targets()[0], plan_of(of_, rows), params_,
                    rows, of_.resources.threads, progress},
                   results);
  return results;
}

} // namespace paradesc
