// Every backend against exact values, on surfaces whose curvatures have a closed form.
//
// By default each case runs once. PARADESC_LONG_TESTS adds meshes, seeds, regular grids and bent UV maps.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <tuple>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/percent_ae.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;
const std::vector<std::string> measured{"mean_curvature", "gaussian_curvature", "local_bending_energy", "sphere_volume"};

// One row of the table that a person reads, and the same in the XML report.
void record(const std::string &what, const std::string &descriptor, const PercentAe &error) {
  std::ostringstream row;
  row << std::left << std::setw(44) << what << std::setw(22) << descriptor << std::fixed << std::setprecision(4) << "%AE mean "
      << error.mean << "  median " << error.median << "  p99 " << error.p99 << "  max " << error.max << "  (" << error.count
      << ")";
  std::cout << row.str() << '\n';
  std::string key = what + "_" + descriptor;
  std::replace_if(
      key.begin(), key.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  ::testing::Test::RecordProperty(key, std::to_string(error.mean));
}

TestMesh test_torus(const Triangulation &triangulation = {}) { return torus(1, 0.4, triangulation); }
TestMesh test_ellipsoid(const Triangulation &triangulation = {}) { return ellipsoid(1, 0.75, 0.5, triangulation); }

// ---- The figures asked for: irregular torus and ellipsoid, 1 to 60 charts

struct Errors {
  PercentAe all, seams, interior;
};

Errors errors_of(std::span<const float> values, std::span<const double> truth, std::span<const uint8_t> seam) {
  return {percent_ae(values, truth), percent_ae(values, truth, seam),
          percent_ae(values, truth, without(std::vector<uint8_t>(seam.size(), 1), seam))};
}

class IrregularSurface : public ::testing::TestWithParam<std::tuple<const char *, int, double>> {
protected:
  void SetUp() override {
    const auto [surface, charts, fraction] = GetParam();
    mesh = std::string(surface) == "torus" ? test_torus() : test_ellipsoid();
    lay_out(mesh, {.charts = charts});
    settings.radius = fraction;
    std::ostringstream name;
    name << surface << ", " << charts << " charts, r " << fraction * 100 << " %";
    title = name.str();
    std::string why_not;
    reference = open_context(PDESC_BACKEND_REFERENCE, why_not);
    ASSERT_TRUE(reference);
    software = open_context(device_backend(), why_not);
    if (!software) GTEST_SKIP() << why_not;
  }

  TestMesh mesh;
  Settings settings; // 256 samples, buffer 1024, fitted normals
  std::string title;
  Context reference, software;
};

TEST_P(IrregularSurface, has_its_exact_curvatures_and_the_oracles_volume_and_bending) {
  const Results results = compute(software.get(), mesh, settings, measured);
  const Results oracle = compute(reference.get(), mesh, settings, measured);
  std::cout << title << ": " << mesh.vertex_count << " vertices, radius in texels " << results.report.radius_in_texels
            << ", coverage " << results.report.coverage_mean << '\n';
  const std::vector<uint8_t> seam = near_seam(mesh, results.report.radius);
  for (size_t i = 0; i < measured.size(); ++i) {
    const std::vector<double> truth = i == 0 ? mesh.H : i == 1 ? mesh.K : as_double(oracle[measured[i]]);
    const Errors errors = errors_of(results[measured[i]], truth, seam);
    record(title, measured[i], errors.all);
    record(title + ", seams", measured[i], errors.seams);
    record(title + ", interior", measured[i], errors.interior);
    // The bounds: 0.25 % of H and K against exact values, 1 % of the others against the oracle. Exact normals alone leave
    // 0.08 to 0.18 % (native/README.md, "Normals decide"), fitted ones 0.02 to 0.05 % more.
    EXPECT_LE(errors.all.mean, i < 2 ? 0.25 : 1.0) << measured[i];
    // Seam vertices err at most 1.5 times as much as the interior. The bias of a finite neighborhood is larger at some places,
    // with or without seams: the oracle, which knows no seams, shows by how much.
    double ratio = 1;
    if (i < 2) {
      const Errors of_oracle = errors_of(oracle[measured[i]], truth, seam);
      record(title + ", oracle", measured[i], of_oracle.all);
      EXPECT_LE(of_oracle.all.mean, 0.25) << measured[i] << " of the oracle";
      ratio = std::max(1.0, of_oracle.seams.mean / of_oracle.interior.mean);
      std::cout << "seams to interior: " << errors.seams.mean / errors.interior.mean << ", of the oracle " << ratio << '\n';
    }
    // If the radius spans few texels, those that a seam cuts are a large part of the neighborhood, and each stands for its
    // covered part by its center: sphere volume has 1.55 to 1.73 times the interior's error on six triangulations of the torus of
    // one chart (6 texels, 0.24 % against 0.145 %), 1.7502 times on this one.
    const double allowed = results.report.radius_in_texels < 8 ? 1.8 : 1.5;
    EXPECT_LE(errors.seams.mean, allowed * ratio * errors.interior.mean) << measured[i];
  }
  // Issue "Core": coverage within 1 % of the oracle's area.
  EXPECT_NEAR(results.report.coverage_mean, 1, 0.01);
}

std::string figures_name(const ::testing::TestParamInfo<std::tuple<const char *, int, double>> &info) {
  const auto [surface, charts, fraction] = info.param;
  return std::string(surface) + "_" + std::to_string(charts) + "_charts_r_" + std::to_string(std::lround(fraction * 100)) +
         "_percent";
}
INSTANTIATE_TEST_SUITE_P(, IrregularSurface,
                         ::testing::Combine(::testing::Values("torus", "ellipsoid"), ::testing::Values(1, 6, 15, 60),
                                            ::testing::Values(0.01, 0.02)),
                         figures_name);

// Meshes of other sizes and seeds, bent charts: the same figures, when asked for.
void expect_exact_curvatures(pdesc_context *software, pdesc_context *reference, TestMesh mesh, const std::string &name,
                             bool bounded) {
  for (const Layout &layout : {Layout{.charts = 6, .seed = 2, .offset = 0.2}, Layout{.charts = 15, .seed = 3, .anisotropy = 1.5},
                               Layout{.charts = 60, .seed = 4, .warp = 0.3}}) {
    lay_out(mesh, layout);
    for (const double fraction : {0.01, 0.02}) {
      const Results results = compute(software, mesh, {.radius = fraction}, measured);
      const Results oracle = compute(reference, mesh, {.radius = fraction}, measured);
      std::ostringstream title;
      title << name << ' ' << mesh.vertex_count << ", " << layout.charts << " charts, r " << fraction * 100 << " %";
      for (size_t i = 0; i < 2; ++i) {
        const std::vector<double> &exact = i == 0 ? mesh.H : mesh.K;
        const PercentAe error = percent_ae(results[measured[i]], exact), of_oracle = percent_ae(oracle[measured[i]], exact);
        record(title.str(), measured[i], error);
        record(title.str() + ", oracle", measured[i], of_oracle);
        // Issue "Core" bounds torus and ellipsoid. Elsewhere the bias of a finite neighborhood is what it is: 0.24 % of a rounded
        // cube's H even at 60 K vertices with exact normals; sampling may add 0.05 %, as it does on the other two.
        EXPECT_LE(error.mean, bounded ? 0.25 : of_oracle.mean + 0.05) << title.str() << ' ' << measured[i];
      }
    }
  }
}

TEST(IrregularSurfaces, keep_their_exact_curvatures_for_other_sizes_seeds_and_layouts) {
  if (!long_tests()) GTEST_SKIP() << "set PARADESC_LONG_TESTS to run it";
  std::string why_not;
  const Context reference = open_context(PDESC_BACKEND_REFERENCE, why_not), software = open_context(device_backend(), why_not);
  if (!software) GTEST_SKIP() << why_not;
  for (const int vertices : {15000, 25000})
    for (const uint32_t seed : {2u, 3u}) {
      const Triangulation triangulation{.vertices = vertices, .seed = seed};
      expect_exact_curvatures(software.get(), reference.get(), test_torus(triangulation), "torus", true);
      expect_exact_curvatures(software.get(), reference.get(), test_ellipsoid(triangulation), "ellipsoid", true);
      expect_exact_curvatures(software.get(), reference.get(), goursat(0.5, triangulation), "goursat", false);
    }
}

// ---- Both backends

class Analytic : public OnBackend {
protected:
  Results compute(const TestMesh &mesh, const Settings &settings) {
    return test::compute(context.get(), mesh, settings, measured);
  }
  void expect_exact(const std::string &what, const std::vector<float> &values, const std::vector<double> &exact, double percent,
                    std::span<const uint8_t> subset = {}, double flat_scale = 0) {
    const PercentAe error = percent_ae(values, exact, subset, flat_scale);
    record(what, "", error);
    EXPECT_LE(error.mean, percent) << what;
    EXPECT_GT(error.count, 0) << what;
  }
};
PDESC_ON_EACH_BACKEND(Analytic);

// How far a sphere's triangles lie below it on average: the mean of rho²/(2R) over each.
double mean_depth(const TestMesh &mesh, double sphere_radius) {
  double depth = 0, total = 0;
  for (size_t c = 0; c < mesh.corner_vertices.size(); c += 3) {
    const auto point = [&](size_t i) { return mesh.points[static_cast<size_t>(mesh.corner_vertices[c + i])]; };
    const Vec3 a = point(1) - point(0), b = point(2) - point(1), d = point(0) - point(2);
    const double area = length(cross(a, b));
    depth += area * (dot(a, a) + dot(b, b) + dot(d, d)) / (24 * sphere_radius);
    total += area;
  }
  return depth / total;
}

// 0.25 %: the torus' bound. A sphere has no bias at any radius, so what is left is the normals' and the chords' error. Triangles
// below the sphere take pi r² times their depth from the lens of two balls.
TEST_P(Analytic, sphere_has_its_curvatures_bending_and_volume) {
  TestMesh mesh = sphere(2);
  lay_out(mesh, {.charts = 15});
  const double depth = mean_depth(mesh, 2);
  for (const double fraction : {0.01, 0.02}) {
    const Results results = compute(mesh, {.radius = fraction});
    const double r = results.report.radius, lens = 2 * pi * r * r * r / 3 - pi * r * r * r * r / (4 * 2);
    const std::string title = "sphere, r " + std::to_string(fraction);
    expect_exact(title + " H", results["mean_curvature"], mesh.H, 0.25);
    expect_exact(title + " K", results["gaussian_curvature"], mesh.K, 0.25);
    expect_exact(title + " LBE", results["local_bending_energy"], mesh.K, 0.25);
    expect_exact(title + " V_r", results["sphere_volume"], std::vector<double>(mesh.points.size(), lens - pi * r * r * depth),
                 0.25);
  }
}

// Scaled by 1/r and 1/r². 1e-3 %: float positions of size 1 are rounded to 6e-8, which over r = 0.04 turns a
// normal by 1e-6 at most; half-texel weights do not matter where every summand is zero.
TEST_P(Analytic, plane_is_flat_over_interior_vertices) {
  TestMesh mesh = plane(2, 1.5, {.vertices = 10000});
  lay_out(mesh, {.charts = 6});
  rotate(mesh, rotation_about({1, -2, 0.5}, 1.1));
  const Results results = compute(mesh, {});
  const double r = results.report.radius;
  const std::vector<uint8_t> inside = interior(mesh, r);
  expect_exact("plane H", results["mean_curvature"], mesh.H, 1e-3, inside, 1 / r);
  expect_exact("plane K", results["gaussian_curvature"], mesh.K, 1e-3, inside, 1 / (r * r));
  expect_exact("plane LBE", results["local_bending_energy"], mesh.K, 1e-3, inside, 1 / (r * r));
  expect_exact("plane V_r", results["sphere_volume"], std::vector<double>(inside.size(), 2 * pi * r * r * r / 3), 1e-3, inside);
}

// 0.25 %, the torus' bound. K is zero: measured against 1/R². Vertices one radius and a half from the boundary: jets at the
// boundary are one-sided, and their normals reach one radius further.
TEST_P(Analytic, cylinder_has_its_curvatures_over_interior_vertices) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 15000});
  lay_out(mesh, {.charts = 6});
  const Results results = compute(mesh, {});
  const std::vector<uint8_t> inside = interior(mesh, 1.5 * results.report.radius);
  expect_exact("cylinder H", results["mean_curvature"], mesh.H, 0.25, inside);
  expect_exact("cylinder K", results["gaussian_curvature"], mesh.K, 0.25, inside, 4);
  // LBE tends to 1/(2R²) as r → 0; r/R = 0.09 keeps the O(r²) rest, r²/(8 R²), below 0.1 %.
  expect_exact("cylinder LBE", results["local_bending_energy"], std::vector<double>(inside.size(), 2), 0.4, inside);
}

TEST_P(Analytic, saddle_has_its_curvatures_over_interior_vertices) {
  TestMesh mesh = saddle(1, {.vertices = 15000});
  lay_out(mesh, {.charts = 6});
  const Results results = compute(mesh, {});
  const std::vector<uint8_t> inside = interior(mesh, 1.5 * results.report.radius);
  expect_exact("saddle H", results["mean_curvature"], mesh.H, 0.25, inside); // the torus' bound
  expect_exact("saddle K", results["gaussian_curvature"], mesh.K, 0.25, inside);
}

// H is zero: measured against the largest k1, 1/neck, which is far stricter than 1/r.
TEST_P(Analytic, catenoid_has_no_mean_curvature_over_interior_vertices) {
  TestMesh mesh = catenoid(0.5, 0.6, {.vertices = 15000});
  lay_out(mesh, {.charts = 6});
  const Results results = compute(mesh, {});
  const std::vector<uint8_t> inside = interior(mesh, 1.5 * results.report.radius);
  expect_exact("catenoid H", results["mean_curvature"], mesh.H, 0.25, inside, 2); // the torus' bound
  expect_exact("catenoid K", results["gaussian_curvature"], mesh.K, 0.25, inside);
}

TEST_P(Analytic, regular_grids_have_their_exact_curvatures) {
  for (TestMesh mesh : {test_torus({.irregular = false}), test_ellipsoid({.irregular = false})}) {
    lay_out(mesh, {.charts = 15});
    const Results results = compute(mesh, {});
    const std::string title = mesh.domain == Domain::sphere ? "regular ellipsoid" : "regular torus";
    expect_exact(title + " H", results["mean_curvature"], mesh.H, 0.25); // an irregular mesh's bound
    expect_exact(title + " K", results["gaussian_curvature"], mesh.K, 0.25);
  }
}

// ---- Invariance. Two results differ by no more than the larger of their errors against exact values.

class Invariance : public Analytic {
protected:
  void expect_unchanged(const std::string &what, const Results &before, const Results &after, const TestMesh &mesh) {
    const std::vector<double> *exact[]{&mesh.H, &mesh.K};
    for (size_t i = 0; i < 2; ++i) {
      const std::vector<float> &a = before[measured[i]], &b = after[measured[i]];
      const PercentAe change = percent_ae(b, as_double(a));
      record(what + ", change", measured[i], change);
      const double error = std::max(percent_ae(a, *exact[i]).mean, percent_ae(b, *exact[i]).mean);
      EXPECT_LE(change.mean, error) << measured[i];
    }
    for (size_t i = 2; i < measured.size(); ++i) {
      const PercentAe change = percent_ae(after[measured[i]], as_double(before[measured[i]]));
      record(what + ", change", measured[i], change);
      EXPECT_LE(change.mean, 1.0) << measured[i]; // the bound of their error against the oracle
    }
  }
};
PDESC_ON_EACH_BACKEND(Invariance);

// Object space never looks at the UV map.
class LayoutInvariance : public Invariance {};
INSTANTIATE_TEST_SUITE_P(, LayoutInvariance, ::testing::Values(device_backend()), backend_name);

TEST_P(LayoutInvariance, moving_the_seams_changes_no_more_than_the_error) {
  for (TestMesh mesh : {test_torus(), test_ellipsoid()}) {
    lay_out(mesh, {.charts = 15});
    const Results before = compute(mesh, {});
    lay_out(mesh, {.charts = 15, .seed = 2, .offset = 0.3});
    expect_unchanged("seams moved", before, compute(mesh, {}), mesh);
  }
}

TEST_P(LayoutInvariance, one_chart_or_sixty_changes_no_more_than_the_error) {
  TestMesh mesh = test_torus();
  lay_out(mesh, {.charts = 1});
  const Results before = compute(mesh, {});
  lay_out(mesh, {.charts = 60});
  expect_unchanged("60 charts for 1", before, compute(mesh, {}), mesh);
}

TEST_P(LayoutInvariance, bending_and_stretching_the_charts_changes_no_more_than_the_error) {
  TestMesh mesh = test_torus();
  lay_out(mesh, {.charts = 6});
  const Results before = compute(mesh, {});
  lay_out(mesh, {.charts = 6, .anisotropy = 1.5, .warp = 0.3});
  expect_unchanged("charts bent", before, compute(mesh, {}), mesh);
}

TEST_P(Invariance, rotating_in_space_changes_no_more_than_the_error) {
  TestMesh mesh = test_ellipsoid();
  lay_out(mesh, {.charts = 15});
  // The same radius: the bounding box turns with the mesh.
  const Settings settings{.radius = 0.05, .radius_unit = PDESC_RADIUS_ABSOLUTE};
  const Results before = compute(mesh, settings);
  rotate(mesh, rotation_about({3, 1, -2}, 0.8));
  expect_unchanged("rotated", before, compute(mesh, settings), mesh);
}

TEST_P(Invariance, scaling_with_the_radius_scales_the_results) {
  TestMesh mesh = test_ellipsoid();
  lay_out(mesh, {.charts = 15});
  const Results before = compute(mesh, {});
  constexpr double factor = 37;
  scale(mesh, factor);
  Results after = compute(mesh, {});
  const int power[]{-1, -2, -2, 3};
  for (size_t i = 0; i < measured.size(); ++i)
    for (float &value : after.values.at(measured[i])) value = static_cast<float>(value / std::pow(factor, power[i]));
  scale(mesh, 1 / factor);
  expect_unchanged("scaled", before, after, mesh);
}

TEST_P(Invariance, two_runs_give_the_same_bits) {
  TestMesh mesh = test_torus();
  lay_out(mesh, {.charts = 15});
  const Results first = compute(mesh, {});
  std::string why_not;
  context = open_context(GetParam(), why_not); // in another context, too
  const Results second = compute(mesh, {});
  for (const auto &[name, values] : first.values) expect_same_bits(values, second[name]);
  EXPECT_EQ(first.mask, second.mask);
}

TEST_P(Invariance, vertices_split_at_the_seams_get_the_results_of_the_whole) {
  TestMesh mesh = test_torus({.vertices = 6000});
  lay_out(mesh, {.charts = 15});
  const SplitMesh split = split_at_seams(mesh);
  const Results whole = compute(mesh, {}), parts = compute(split.mesh, {});
  for (const std::string &name : measured) {
    std::vector<double> expected;
    for (const int32_t origin : split.origin) expected.push_back(whole[name][static_cast<size_t>(origin)]);
    const PercentAe change = percent_ae(parts[name], expected);
    record("vertices split", name, change);
    EXPECT_LE(change.mean, 0.25) << name; // the error that another choice among a vertex's wedges may make
  }
}

} // namespace
} // namespace paradesc::test
