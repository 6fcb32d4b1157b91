// The registry's rows, one by one: every engine against the reference, alone against together.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/oracle.h"
#include "support/percent_ae.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

class Parity : public ::testing::TestWithParam<int32_t> {
protected:
  void SetUp() override {
    std::string why_not;
    reference = open_context(PDESC_BACKEND_REFERENCE, why_not);
    ASSERT_TRUE(reference);
    engine = open_context(GetParam(), why_not);
    if (!engine) GTEST_SKIP() << why_not;
    if (GetParam() == PDESC_BACKEND_CPU) {
      names = registered_descriptors();
      return;
    }
    // Operators make up to 2 % of what samples that march leave of the map's smoothness.
    names = descriptors_of_devices();
    std::erase_if(names, [](const std::string &name) { return map_degree_of(name) > 0; });
  }

  // The oracle is asked at some thousand vertices, and for operators, whose windows are wide, at some hundred: all would take it
  // minutes.
  Results expect_parity(const TestMesh &mesh, const Settings &settings) {
    const Results fast = compute(engine.get(), mesh, settings, names);
    std::vector<std::string> of_surface, of_map;
    for (const std::string &name : names) (map_degree_of(name) > 0 ? of_map : of_surface).push_back(name);
    std::vector<int32_t> vertices(mesh.points.size());
    std::iota(vertices.begin(), vertices.end(), 0);
    compare(fast, mesh, settings, some_of(vertices, 2500), of_surface);
    if (!of_map.empty()) compare(fast, mesh, settings, clusters_of(mesh, 12, 40), of_map);
    // Nothing is undefined but where there is no face, at every vertex.
    for (size_t v = 0; v < mesh.points.size(); ++v)
      for (const std::string &name : names)
        EXPECT_EQ(std::isnan(fast[name][components_of(name) * v]), (fast.mask[v] & PDESC_MASK_NO_FACE) != 0)
            << name << " at vertex " << v;
    const auto loose = std::ranges::count_if(fast.mask, [](uint8_t mask) { return (mask & PDESC_MASK_NO_FACE) != 0; });
    EXPECT_EQ(fast.report.undefined_vertices, loose);
    EXPECT_NEAR(fast.report.radius, settings.radius * mesh.diagonal(), 1e-9 * fast.report.radius);
    EXPECT_NEAR(fast.report.coverage_mean, 1, 0.01); // next to nothing is lost
    return fast;
  }

  static void compare(const Results &fast, const TestMesh &mesh, const Settings &settings, const std::vector<int32_t> &vertices,
                      const std::vector<std::string> &requested) {
    const Oracle oracle = ask_oracle(mesh, fast.report.radius, settings, vertices, requested);
    for (const std::string &name : requested) {
      const std::vector<float> values = pick(fast[name], vertices, components_of(name));
      const std::vector<double> &expected = oracle[name];
      if (components_of(name) == 3) {
        expect_same_directions(values, expected, oracle);
        continue;
      }
      const bool mask = name == "cavity" || name == "convexity"; // zero on half of all surfaces, and without a unit
      const PercentAe error = percent_ae(values, expected, {}, mask ? 1.0 : 0.0);
      const double relative = relative_error(values, expected);
      std::cout << std::left << std::setw(26) << name << std::fixed << std::setprecision(4) << "%AE mean " << error.mean
                << "  p99 " << error.p99 << "  max " << error.max << "  relative " << relative << " %\n";
      RecordProperty(name, std::to_string(error.mean));
      // Issue "Core": 1 % for every descriptor; the area within 1 % of the oracle's. If the reference varies by less than 1 % of
      // itself (k1 of a torus: 1/r, but for the bias of a finite neighborhood), its range is no measure, and the error must be
      // below 1 % of the value.
      double largest = 0;
      for (const double value : expected)
        if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
      const bool by_itself = name == "euclidean_area" || name == "geodesic_area" || error.range < 0.01 * largest;
      for (size_t v = 0; v < expected.size(); ++v)
        ASSERT_EQ(std::isnan(values[v]), std::isnan(expected[v]))
            << name << " at vertex " << vertices[v] << " is defined on one side only";
      // K of eq. (11) is a difference of areas over r^4: on these surfaces 0.04 % of GA are 4 % of K's range. The test of
      // integrals checks the descriptors that follow from H and K.
      if (settings.estimator == PDESC_ESTIMATOR_INTEGRAL && follows_from_k(name)) continue;
      const bool of_areas = settings.estimator == PDESC_ESTIMATOR_INTEGRAL && name == "gaussian_curvature";
      // A product of four gradients has four times their relative error.
      const double allowed = of_areas ? 5.0 : PDESC_PARITY_PERCENT * (by_itself ? std::max(map_degree_of(name), 1) : 1);
      EXPECT_LE(by_itself ? relative : error.mean, allowed) << name;
      // Half a normal distribution's mean is 0.8 of its deviation, and the worst of thousands beyond four; beside seams and where
      // samples lie on the rim tails are heavier. Operators are held to their range over a few regions, harris to its product of
      // four. Measured on llvmpipe: 2.1 and 3.3, of operators 4.1 and 7.9, of harris 8.2 and 12.3 times what is allowed of the
      // mean.
      const double heavier = map_degree_of(name) > 1   ? 4
                             : map_degree_of(name) > 0 ? 2
                                                       : 1,
                   unit = by_itself ? error.range / largest : 1;
      EXPECT_LE(unit * error.p99, 3 * heavier * allowed) << name;
      EXPECT_LE(unit * error.max, 5 * heavier * allowed) << name;
    }
  }

  // Issue "All of the paper": the mean angle, weighted by |k1 - k2|, within 1 degree.
  static void expect_same_directions(std::span<const float> values, std::span<const double> expected, const Oracle &oracle) {
    double sum = 0, total = 0;
    for (size_t v = 0; 3 * v < values.size(); ++v) {
      double along = 0;
      for (size_t i = 3 * v; i < 3 * v + 3; ++i) along += static_cast<double>(values[i]) * expected[i];
      ASSERT_EQ(std::isnan(values[3 * v]), std::isnan(expected[3 * v])) << "vertex " << v << " has a direction on one side only";
      if (std::isnan(along)) continue;
      const double weight = oracle["principal_curvature_max"][v] - oracle["principal_curvature_min"][v];
      sum += weight * std::acos(std::min(std::abs(along), 1.0)) * 57.29577951308232;
      total += weight;
    }
    ASSERT_GT(total, 0);
    std::cout << "direction, mean angle " << sum / total << " degrees\n";
    EXPECT_LE(sum / total, PDESC_PARITY_DEGREES);
  }

  static bool follows_from_k(const std::string &name) {
    return name == "principal_curvature_max" || name == "principal_curvature_min" || name == "shape_index" ||
           name == "curvedness";
  }

  // 100 mean |x - ref| / mean |ref|.
  static double relative_error(std::span<const float> values, std::span<const double> expected) {
    double difference = 0, total = 0;
    for (size_t v = 0; v < values.size(); ++v) {
      if (!std::isfinite(values[v]) || !std::isfinite(expected[v])) continue;
      difference += std::abs(static_cast<double>(values[v]) - expected[v]);
      total += std::abs(expected[v]);
    }
    return 100 * difference / total;
  }

  Context reference, engine;
  std::vector<std::string> names;
};

TEST_P(Parity, every_descriptor_agrees_with_the_oracle_on_a_torus_of_60_charts) {
  TestMesh mesh = torus(1, 0.4);
  lay_out(mesh, {.charts = 60});
  expect_parity(mesh, {});
}

TEST_P(Parity, every_descriptor_agrees_with_the_oracle_on_an_ellipsoid_of_15_charts) {
  TestMesh mesh = ellipsoid(1, 0.75, 0.5);
  lay_out(mesh, {.charts = 15});
  expect_parity(mesh, {});
}

TEST_P(Parity, every_descriptor_agrees_with_the_oracle_at_twice_the_radius) {
  TestMesh mesh = torus(1, 0.4);
  lay_out(mesh, {.charts = 15});
  expect_parity(mesh, {.radius = 0.04});
}

TEST_P(Parity, every_descriptor_agrees_with_the_oracle_along_the_surface) {
  TestMesh mesh = ellipsoid(1, 0.75, 0.5);
  lay_out(mesh, {.charts = 15});
  expect_parity(mesh, {.radius = 0.06, .distance = PDESC_DISTANCE_GEODESIC, .map_sigma = 0.5});
}

TEST_P(Parity, integrals_agree_with_the_oracle) {
  if (GetParam() != PDESC_BACKEND_CPU) GTEST_SKIP() << "K of single vertices hangs on samples at the rim";
  TestMesh mesh = ellipsoid(1, 0.75, 0.5);
  lay_out(mesh, {.charts = 15});
  expect_parity(mesh, {.radius = 0.06, .estimator = PDESC_ESTIMATOR_INTEGRAL, .map_sigma = 0.5});
  expect_parity(mesh,
                {.radius = 0.06, .estimator = PDESC_ESTIMATOR_INTEGRAL, .distance = PDESC_DISTANCE_GEODESIC, .map_sigma = 0.5});
}

TEST_P(Parity, extrapolated_curvatures_agree_with_the_oracle) {
  if (GetParam() != PDESC_BACKEND_CPU) GTEST_SKIP() << "areas of single vertices err by more where ellipses are as large";
  TestMesh mesh = ellipsoid(1, 0.75, 0.5, {.vertices = 3000});
  lay_out(mesh, {.charts = 15});
  expect_parity(mesh, {.radius = 0.08, .estimator = PDESC_ESTIMATOR_EXTRAPOLATED, .map_sigma = 0.5});
  expect_parity(
      mesh, {.radius = 0.08, .estimator = PDESC_ESTIMATOR_EXTRAPOLATED, .distance = PDESC_DISTANCE_GEODESIC, .map_sigma = 0.5});
}

// Paper eq. (8), (11), (10) and (9), from the library's own V_r and GA.
TEST_P(Parity, curvatures_of_the_integral_estimator_follow_from_volume_and_area) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 3000});
  lay_out(mesh, {.charts = 6});
  const std::vector<std::string> followed{
      "sphere_volume",           "geodesic_area",           "mean_curvature", "gaussian_curvature",
      "principal_curvature_max", "principal_curvature_min", "shape_index",    "curvedness"};
  for (pdesc_context *context : {reference.get(), engine.get()}) {
    const Results results = compute(context, mesh, {.radius = 0.06, .estimator = PDESC_ESTIMATOR_INTEGRAL}, followed);
    const double r = results.report.radius, pi = std::numbers::pi;
    for (size_t v = 0; v < mesh.points.size(); ++v) {
      const auto at = [&](const char *name) { return static_cast<double>(results[name][v]); };
      const double h = 4 / (pi * r * r * r * r) * (2 * pi * r * r * r / 3 - at("sphere_volume"));
      const double k = 12 * (pi * r * r - at("geodesic_area")) / (pi * r * r * r * r);
      const double root = std::sqrt(std::max(h * h - k, 0.0));
      // A float of V_r, and of GA, has 1e-7 of its value: r^-1 and r^-2 times a few of those.
      ASSERT_NEAR(at("mean_curvature"), h, 2e-6 / r) << "vertex " << v;
      ASSERT_NEAR(at("gaussian_curvature"), k, 1e-5 / (r * r)) << "vertex " << v;
      if (root < 0.1 / r) continue; // the root's slope
      ASSERT_NEAR(at("principal_curvature_max"), h + root, 1e-4 / r) << "vertex " << v;
      ASSERT_NEAR(at("principal_curvature_min"), h - root, 1e-4 / r) << "vertex " << v;
      ASSERT_NEAR(at("shape_index"), 2 / pi * std::atan(h / root), 1e-3) << "vertex " << v;
      ASSERT_NEAR(at("curvedness"), std::sqrt(h * h + root * root), 1e-4 / r) << "vertex " << v;
    }
  }
}

TEST_P(Parity, adaptive_sampling_agrees_with_the_oracle) {
  if (GetParam() == PDESC_BACKEND_CPU) GTEST_SKIP() << "it takes all samples everywhere";
  TestMesh mesh = ellipsoid(1, 0.75, 0.5);
  lay_out(mesh, {.charts = 15});
  expect_parity(mesh, {.radius = 0.04, .adaptive = 0.002, .map_sigma = 0.5});
}

// The mesh has three vertices that no face uses.
TestMesh open_surface(int vertices) {
  TestMesh mesh = saddle(1, {.vertices = vertices});
  lay_out(mesh, {.charts = 6});
  mesh.points.insert(mesh.points.end(), 3, Vec3{0.1, 0.2, 0.3});
  mesh.normals.insert(mesh.normals.end(), 3, Vec3{0, 0, 1});
  mesh.vertex_count += 3;
  round_to_float(mesh);
  return mesh;
}

TEST_P(Parity, every_descriptor_agrees_with_the_oracle_on_an_open_surface_with_loose_vertices) {
  const TestMesh mesh = open_surface(8000);
  const Results fast = expect_parity(mesh, {});
  for (size_t v = 0; v < mesh.points.size(); ++v)
    ASSERT_EQ((fast.mask[v] & PDESC_MASK_NO_FACE) != 0, v + 3 >= mesh.points.size()) << "vertex " << v;
  EXPECT_EQ(fast.report.undefined_vertices, 3);
}

TEST_P(Parity, loose_vertices_are_undefined_on_both_sides) {
  const TestMesh mesh = open_surface(1000);
  for (pdesc_context *context : {reference.get(), engine.get()}) {
    const Results results = compute(context, mesh, {.radius = 0.05}, names);
    for (size_t v = 0; v < mesh.points.size(); ++v) {
      ASSERT_EQ((results.mask[v] & PDESC_MASK_NO_FACE) != 0, v + 3 >= mesh.points.size()) << "vertex " << v;
      if (v + 3 < mesh.points.size()) continue;
      for (const std::string &name : names) EXPECT_TRUE(std::isnan(results[name][components_of(name) * v])) << name;
    }
    EXPECT_EQ(results.report.undefined_vertices, 3);
  }
}

// Boundaries are seen by both, though each in its own way: texture space by the samples that meet one.
TEST_P(Parity, the_boundary_mask_agrees_with_the_oracle) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const std::vector<std::string> any{"mean_curvature"};
  const Results fast = compute(engine.get(), mesh, {}, any), oracle = compute(reference.get(), mesh, {}, any);
  const double r = fast.report.radius;
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    // A tenth of the radius on either side of the rim is left to the samples' spacing, r/16, and to the triangles' edges.
    if (mesh.boundary_distance[v] > 0.9 * r && mesh.boundary_distance[v] < 1.1 * r) continue;
    const bool cut = mesh.boundary_distance[v] < r;
    ASSERT_EQ((fast.mask[v] & PDESC_MASK_BOUNDARY) != 0, cut) << "software, vertex " << v;
    ASSERT_EQ((oracle.mask[v] & PDESC_MASK_BOUNDARY) != 0, cut) << "reference, vertex " << v;
  }
}

// Together they share one sampling, and must not share more. On the CPU, areas and the bending energy take smaller triangles,
// which the others share then. A card's compiler fuses the sums of each program as it likes.
TEST_P(Parity, a_descriptor_alone_has_the_values_it_has_among_the_others) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 800});
  lay_out(mesh, {.charts = 6});
  const Settings settings{.radius = 0.08, .buffer_size = 512}; // some twenty vertices to a ball
  for (pdesc_context *context : {reference.get(), engine.get()}) {
    const Results together = compute(context, mesh, settings, names);
    for (const std::string &name : names) {
      SCOPED_TRACE(name);
      const std::vector<float> alone = compute(context, mesh, settings, std::span(&name, 1))[name];
      if (context == reference.get() || GetParam() == PDESC_BACKEND_SOFTWARE) {
        expect_same_bits(alone, together[name]);
        continue;
      }
      double gaps = 0, sizes = 0;
      for (size_t i = 0; i < alone.size(); ++i) {
        gaps += std::abs(static_cast<double>(alone[i]) - static_cast<double>(together[name][i]));
        sizes += std::abs(static_cast<double>(together[name][i]));
      }
      EXPECT_LE(gaps, (GetParam() == PDESC_BACKEND_CPU ? 1e-3 : 1e-6) * sizes);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, Parity, ::testing::Values(device_backend(), int32_t{PDESC_BACKEND_CPU}), backend_name);

} // namespace
} // namespace paradesc::test
