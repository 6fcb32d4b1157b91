// A mesh → the exact pass's values at its points or at any centers, and the reference's.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "descriptor/registry.h"
#include "descriptor/results.h"
#include "engine/cpu/exact_pass.h"
#include "engine/cpu/patched_mesh.h"
#include "engine/reference/reference.h"

namespace paradesc::test {

struct ExactSetting {
  std::vector<int> rows;
  SumKind kind = SumKind::fit;
  float clusters = 0.0f;   // largest spread of clusters, in squares of the radius; 0: all points are single
  float triangles = 0.05f; // largest spread of the samples of triangles, in squares of the radius
  int threads = 2;
  BallTarget ball_target = ball_targets()[0];
  SumTarget sum_target = sum_targets()[0];
};

inline std::vector<int> rows_named(std::initializer_list<const char *> names) {
  std::vector<int> rows;
  for (const char *const name : names) rows.push_back(find_descriptor(name));
  return rows;
}
// Triangles have moments, and only large ones are listed.
inline ExactSetting by_moments() { return {.rows = rows_named({"mean_curvature", "gaussian_curvature", "standard_error"})}; }
// All triangles are listed one by one.
inline ExactSetting one_by_one() {
  return {.rows = rows_named({"mean_curvature", "local_bending_energy", "geodesic_area", "sphere_volume"}),
          .kind = SumKind::surface,
          .triangles = 0.005f};
}

inline std::vector<ExactSetting> both_ways() { return {by_moments(), one_by_one()}; }

class ExactSurface : public PatchedMesh {
public:
  using PatchedMesh::PatchedMesh;

  CenterPoints points() const {
    CenterPoints centers;
    const std::vector<vec3> at = positions();
    for (int32_t i = 0; i < half_edges.point_count; ++i) {
      const auto point = static_cast<size_t>(i);
      centers.push_back({at[point], normals.point[point], half_edges.point_half_edge[point] / 3, i});
    }
    return centers;
  }
  PointPatches patches_for(double radius, const ExactSetting &setting) const {
    constexpr float coherence = 0.9f; // as by default
    const float square = scaled(radius) * scaled(radius);
    return patches(setting.clusters > 0.0f ? nodes({setting.clusters * square, coherence}) : single_points());
  }
  // Returns values in the units of the mesh.
  CenterResults evaluate(double radius, const ExactSetting &setting) const {
    return evaluate(radius, setting, points(), {order.tree.item, group_points(order, group_lanes)});
  }
  CenterResults evaluate_at(double radius, const ExactSetting &setting, const CenterPoints &centers) const {
    return evaluate(radius, setting, centers, {});
  }
  ReferenceField reference(double radius, std::span<const int> rows, std::span<const int32_t> at = {}) const {
    return compute_reference(triangles, half_edges, normals, {.radius = radius, .points = at}, rows, 2, nullptr);
  }

private:
  // groups: if empty, they follow from the triangles of the centers.
  CenterResults evaluate(double radius, const ExactSetting &setting, const CenterPoints &centers, CenterGroups groups) const {
    EvaluateParams params{};
    params.radius = scaled(radius);
    const bool with_moments = setting.kind == SumKind::fit;
    const PatchSurface::Needs needs{(with_moments ? 1.0f : 0.35f) * params.radius, with_moments, asks_for_noise(setting.rows)};
    const ListedSurface listed(*this, patches_for(radius, setting), needs, {setting.triangles * params.radius * params.radius},
                               with_moments ? SampledTriangles::large : SampledTriangles::all, setting.ball_target,
                               setting.threads);
    if (groups.begin.empty()) groups = group_centers(listed.patches.node_of_triangle, centers, params.radius, group_lanes);
    CenterResults results = unknown_results(centers.size(), setting.rows);
    evaluate_exactly({listed.patches,
                      listed.surface,
                      listed.samples,
                      listed.sampled,
                      listed.limit,
                      centers,
                      groups,
                      half_edges.triangle_piece,
                      {},
                      setting.ball_target,
                      setting.sum_target,
                      {setting.kind, false, true},
                      params,
                      setting.rows,
                      setting.threads,
                      [](double) {}},
                     results);
    scale_values(setting.rows, space.scale, results);
    return results;
  }
};

using RowValues = std::vector<std::vector<float>>;

// Expects values within a share of the largest of each row. at: some points.
inline void expect_values_near(const RowValues &found, const RowValues &reference, const std::vector<int> &rows,
                               const std::vector<double> &shares, std::span<const int32_t> at) {
  for (size_t k = 0; k < rows.size(); ++k) {
    double largest = 0, worst = 0;
    for (const int32_t point : at) {
      const auto i = static_cast<size_t>(point);
      const auto expected = static_cast<double>(reference[k][i]), value = static_cast<double>(found[k][i]);
      EXPECT_EQ(std::isnan(value), std::isnan(expected)) << "point " << i;
      if (std::isnan(expected)) continue;
      largest = std::max(largest, std::abs(expected));
      worst = std::max(worst, std::abs(value - expected));
    }
    const char *const name = descriptor_row(rows[k]).name;
    EXPECT_GT(largest, 0) << name;
    EXPECT_LT(worst, shares[k] * largest) << name;
  }
}

inline std::vector<int32_t> all_points(const ExactSurface &surface) {
  std::vector<int32_t> points(static_cast<size_t>(surface.half_edges.point_count));
  std::iota(points.begin(), points.end(), 0);
  return points;
}

// Expects values like that, and the same boundary flags, at all points.
inline void expect_near_the_reference(const ExactSurface &surface, double radius, const ExactSetting &setting,
                                      const std::vector<double> &shares) {
  const CenterResults found = surface.evaluate(radius, setting);
  const ReferenceField reference = surface.reference(radius, setting.rows);
  expect_values_near(found.values, reference.values, setting.rows, shares, all_points(surface));
  EXPECT_EQ(found.boundary, reference.boundary);
}

inline void expect_the_same_bits(const CenterResults &a, const CenterResults &b, std::string_view name) {
  for (size_t k = 0; k < a.values.size(); ++k)
    EXPECT_EQ(std::memcmp(a.values[k].data(), b.values[k].data(), a.values[k].size() * sizeof(float)), 0)
        << "row " << k << " by " << name;
  EXPECT_EQ(a.boundary, b.boundary) << name;
}

// Expects the same bits by every set of instructions and any number of threads.
inline void expect_the_same_bits_everywhere(const ExactSurface &surface, double radius, ExactSetting setting) {
  setting.threads = 1;
  const CenterResults first = surface.evaluate(radius, setting);
  const std::vector<BallTarget> balls = ball_targets();
  const std::vector<SumTarget> sums = sum_targets();
  ASSERT_EQ(balls.size(), sums.size());
  for (size_t i = 0; i < balls.size(); ++i)
    for (const int threads : {1, 3}) {
      setting.threads = threads;
      setting.ball_target = balls[i];
      setting.sum_target = sums[i];
      expect_the_same_bits(surface.evaluate(radius, setting), first, balls[i].name);
    }
}

// Expects that the search finds the same neighborhoods from the triangles of points, whose groups are others. Sums of moments are
// rounded otherwise then.
inline void expect_the_same_from_triangles(const ExactSurface &surface, double radius, const ExactSetting &setting) {
  CenterPoints centers = surface.points();
  for (CenterPoint &center : centers) center.point = -1;
  const CenterResults found = surface.evaluate_at(radius, setting, centers), expected = surface.evaluate(radius, setting);
  EXPECT_EQ(found.boundary, expected.boundary);
  const std::vector<double> rounding(setting.rows.size(), 1e-5);
  expect_values_near(found.values, expected.values, setting.rows, rounding, all_points(surface));
}

} // namespace paradesc::test
