// How samples are placed and carried over seams in texture space: each way against the oracle or a closed form.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iostream>
#include <numeric>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/percent_ae.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr Settings affine{.relocation = PDESC_RELOCATION_AFFINE};
constexpr Settings paper{.relocation = PDESC_RELOCATION_PAPER, .max_jumps = 1};

class Relocation : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    reference = open_context(PDESC_BACKEND_REFERENCE, why_not);
    ASSERT_TRUE(reference);
    software = open_context(device_backend(), why_not);
    if (!software) GTEST_SKIP() << why_not;
  }

  // Each descriptor's mean %AE below the limit.
  void expect_errors_below(double limit, const TestMesh &mesh, const Settings &settings, const char *what,
                           const std::vector<std::string> &names = {"mean_curvature", "gaussian_curvature",
                                                                    "local_bending_energy", "sphere_volume_normalized"}) {
    const Results fast = compute(software.get(), mesh, settings, names), oracle = compute(reference.get(), mesh, settings, names);
    std::cout << what << ": coverage " << fast.report.coverage_mean;
    for (const std::string &name : names) {
      const double error = percent_ae(fast[name], as_double(oracle[name])).mean;
      std::cout << ", " << name << " " << error;
      EXPECT_LE(error, limit) << what << ": " << name;
    }
    std::cout << "\n";
  }

  // The area found over the oracle's, and the coverage, at each vertex.
  struct Found {
    std::vector<double> area, coverage;
    double mean_area() const { return std::accumulate(area.begin(), area.end(), 0.0) / static_cast<double>(area.size()); }
    double mean_coverage() const {
      return std::accumulate(coverage.begin(), coverage.end(), 0.0) / static_cast<double>(area.size());
    }
    double least_coverage() const { return *std::ranges::min_element(coverage); }
  };
  Found found(const TestMesh &mesh, Settings settings) {
    const std::string area = "euclidean_area";
    settings.variance_reduction = PDESC_VARIANCE_REDUCTION_NONE; // plain sums: what was found and nothing else
    const Results fast = compute(software.get(), mesh, settings, std::span(&area, 1)),
                  oracle = compute(reference.get(), mesh, settings, std::span(&area, 1));
    Found result;
    for (size_t v = 0; v < mesh.points.size(); ++v) {
      result.area.push_back(static_cast<double>(fast[area][v]) / static_cast<double>(oracle[area][v]));
      result.coverage.push_back(static_cast<double>(fast["coverage"][v]));
    }
    std::cout << "area " << result.mean_area() << ", coverage " << result.mean_coverage() << ", least " << result.least_coverage()
              << "\n";
    return result;
  }

  Context reference, software;
};

TestMesh torus_of(int charts, int vertices = 3000) {
  TestMesh mesh = torus(1, 0.4, {.vertices = vertices});
  lay_out(mesh, {.charts = charts});
  return mesh;
}

Settings with(Settings settings, const std::function<void(Settings &)> &change) {
  change(settings);
  return settings;
}

// Gives the mesh other charts: chart(parameters of a triangle's middle) → chart, uv(chart, parameters of a corner) → (u, v).
void cut(TestMesh &mesh, const std::function<int(double, double)> &chart,
         const std::function<std::pair<double, double>(int, double, double)> &uv) {
  mesh.corner_uvs.clear();
  mesh.triangle_chart.clear();
  for (size_t c = 0; c < mesh.corner_vertices.size(); c += 3) {
    Vec3 corner[3];
    for (size_t i = 0; i < 3; ++i) {
      corner[i] = mesh.parameters[static_cast<size_t>(mesh.corner_vertices[c + i])];
      // A triangle over the end of a period lies on one side of it.
      if (mesh.periodic_u) corner[i].x += std::round(corner[0].x - corner[i].x);
      if (mesh.periodic_v) corner[i].y += std::round(corner[0].y - corner[i].y);
    }
    double least_x = 0, least_y = 0;
    for (const Vec3 &p : corner) {
      least_x = std::max(least_x, p.x);
      least_y = std::max(least_y, p.y);
    }
    const double dx = least_x > 1 + 1e-9 ? -1 : 0, dy = least_y > 1 + 1e-9 ? -1 : 0;
    const double x = (corner[0].x + corner[1].x + corner[2].x) / 3 + dx, y = (corner[0].y + corner[1].y + corner[2].y) / 3 + dy;
    const int number = chart(x, y);
    mesh.triangle_chart.push_back(number);
    for (const Vec3 &p : corner) {
      const auto [u, v] = uv(number, p.x + dx, p.y + dy);
      mesh.corner_uvs.push_back(static_cast<float>(u));
      mesh.corner_uvs.push_back(static_cast<float>(v));
    }
  }
}

TEST_F(Relocation, every_choice_agrees_with_the_oracle_on_a_torus_of_fifteen_charts) {
  const TestMesh mesh = torus_of(15);
  expect_errors_below(1, mesh, affine, "affine");
  expect_errors_below(1, mesh, with(affine, [](Settings &s) { s.pattern = PDESC_PATTERN_STRATIFIED; }), "stratified");
  expect_errors_below(1, mesh, with(affine, [](Settings &s) { s.ellipse = PDESC_ELLIPSE_DIRECTIONAL; }), "directional");
  expect_errors_below(1, mesh, with(affine, [](Settings &s) { s.adaptive = 0.002; }), "adaptive");
  expect_errors_below(1, mesh, paper, "paper");
  expect_errors_below(1, mesh, with(paper, [](Settings &s) { s.pattern = PDESC_PATTERN_STRATIFIED; }), "paper, stratified");
  expect_errors_below(1, mesh, with(paper, [](Settings &s) { s.ellipse = PDESC_ELLIPSE_DIRECTIONAL; }), "paper, directional");
  expect_errors_below(1, mesh, with(paper, [](Settings &s) { s.adaptive = 0.002; }), "paper, adaptive");
}

// The default asks for what hangs together on the surface, which only the CPU and the reference find.
TEST_F(Relocation, in_texture_space_the_default_is_the_affine_relocation) {
  const TestMesh mesh = torus_of(15);
  const std::vector<std::string> names = descriptors_of_devices();
  const Results connected = compute(software.get(), mesh, {}, names), carried = compute(software.get(), mesh, affine, names);
  for (const std::string &name : names) expect_same_bits(connected[name], carried[name]);
  expect_same_bits(connected["coverage"], carried["coverage"]);
}

// The positions are the same but for rounding, which now and then brings a sample to the texel beside it.
TEST_F(Relocation, without_seams_the_papers_samples_are_those_of_the_affine_relocation) {
  TestMesh mesh = saddle(1, {.vertices = 2000});
  lay_out(mesh, {.charts = 1});
  std::vector<std::string> names = registered_descriptors();
  // An operator on a map hands each difference on to all that lies around.
  std::erase_if(names, [](const std::string &name) { return components_of(name) != 1 || map_degree_of(name) > 0; });
  for (const int32_t pattern : {PDESC_PATTERN_GOLDEN_ANGLE, PDESC_PATTERN_STRATIFIED}) {
    const Results a = compute(software.get(), mesh, with(affine, [&](Settings &s) { s.pattern = pattern; }), names),
                  b = compute(software.get(), mesh, with(paper, [&](Settings &s) { s.pattern = pattern; }), names);
    for (const std::string &name : names) {
      size_t same = 0;
      for (size_t v = 0; v < mesh.points.size(); ++v)
        same += a[name][v] == b[name][v] || (std::isnan(a[name][v]) && std::isnan(b[name][v]));
      EXPECT_GT(same, mesh.points.size() * 98 / 100) << name << ": half a million samples, a few of which lie on texels' edges";
      EXPECT_LT(percent_ae(a[name], as_double(b[name])).mean, 0.01) << name;
    }
    EXPECT_EQ(a.mask, b.mask);
  }
}

// One chart that wraps around twice: every neighborhood at its border comes back over seams of the chart with itself. The
// paper's list by (chart, seam) holds four images of a center at the chart's corner but not the one across.
TEST_F(Relocation, a_chart_that_meets_itself_is_found_once) {
  const TestMesh mesh = torus_of(1);
  for (const Settings &settings : {affine, paper}) {
    const Found result = found(mesh, with(settings, [](Settings &s) { s.radius = 0.06; }));
    EXPECT_NEAR(result.mean_area(), 1, 0.005);
    EXPECT_LT(*std::ranges::max_element(result.area), 1.1) << "a part found twice would be a half of it";
    EXPECT_GT(result.mean_coverage(), 0.999);
    EXPECT_GT(result.least_coverage(), settings.relocation == PDESC_RELOCATION_AFFINE ? 0.96 : 0.7);
  }
}

// In a plane the map of each seam is exact, whatever its charts look like. Stretched charts that are turned do not commute:
// beyond the second seam a pattern carried by their maps in another order lies elsewhere.
TEST_F(Relocation, maps_of_several_seams_are_joined_in_the_order_of_the_crossings) {
  TestMesh mesh = plane(1, 1, {.vertices = 1500});
  lay_out(mesh, {.charts = 100, .anisotropy = 2.5});
  for (const Settings &settings : {affine, paper}) {
    const Found result = found(mesh, with(settings, [](Settings &s) {
                                 s.radius = 0.12; // more than a chart is wide
                                 s.max_jumps = 6;
                               }));
    EXPECT_NEAR(result.mean_area(), 1, 0.01);
    EXPECT_GT(result.mean_coverage(), 0.9);
  }
}

// The loss of the paper's one jump, which its section 4.1 reports: what it does not find it must not hide.
TEST_F(Relocation, coverage_tells_what_the_paper_loses_where_charts_are_small) {
  const TestMesh mesh = torus_of(240, 1500);
  double last = 0;
  for (const int jumps : {0, 1, 2, 8}) {
    const Found result = found(mesh, with(paper, [&](Settings &s) {
                                 s.max_jumps = jumps;
                                 s.radius = 0.06;
                               }));
    EXPECT_NEAR(result.mean_coverage(), result.mean_area(), 0.03) << jumps;
    EXPECT_GT(result.mean_coverage(), last);
    last = result.mean_coverage();
    if (jumps <= 1) {
      EXPECT_LT(result.mean_coverage(), 0.95);
    }
  }
  EXPECT_GT(last, 0.98);
}

// Two charts of a square, the seam a straight line of the one and an arc of the other, narrower than the ball: each of its edges
// leads elsewhere. If samples reach the second chart over several edges, the nearest edge carries the center and the pattern.
TEST_F(Relocation, over_a_bent_seam_the_paper_takes_the_nearest_crossing) {
  TestMesh mesh = plane(1, 1, {.vertices = 4000, .irregular = false});
  constexpr double bend = 0.17, scale = 0.4, radius = 0.2; // of the arc, in units of the square
  cut(
      mesh, [](double x, double) { return x < 0.5 ? 0 : 1; },
      [](int chart, double x, double y) {
        if (chart == 0) return std::pair(0.02 + scale * x, 0.05 + scale * y);
        const double angle = (y - 0.5) / bend, away = scale * (bend + x - 0.5);
        return std::pair(0.7 + away * std::cos(angle), 0.5 + away * std::sin(angle));
      });
  const Settings settings = with(paper, [](Settings &s) {
    s.radius = radius;
    s.radius_unit = PDESC_RADIUS_ABSOLUTE;
    s.samples = 1024;
    s.variance_reduction = PDESC_VARIANCE_REDUCTION_NONE; // plain sums: what was found and nothing else
  });
  const std::string area = "euclidean_area";
  const Results results = compute(software.get(), mesh, settings, std::span(&area, 1));
  double sum = 0, worst = 0;
  int count = 0;
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.boundary_distance[v] < 1.1 * radius || mesh.parameters[v].x >= 0.5 || mesh.parameters[v].x < 0.42) continue;
    const double error = static_cast<double>(results[area][v]) / (3.14159265358979323846 * radius * radius) - 1;
    sum += error;
    worst = std::max(worst, std::abs(error));
    ++count;
  }
  std::cout << "area " << sum / count << " off on average, " << worst << " at most, over " << count << " vertices\n";
  ASSERT_GT(count, 100);
  // A tenth of the 1024 samples lie on the rim, and count to a third of their size: 0.4 % at a vertex, measured, four times that
  // at the worst. A center carried over the farthest edge leaves 1.6 % of the ball out on average, and 9 % at the worst.
  EXPECT_NEAR(sum / count, 0, 0.004);
  EXPECT_LT(worst, 0.04);
}

// A torus in strips about one texel wide with wide gaps: no way leads far without a seam. So sparse a map is laid out afresh,
// with strips somewhat wider.
TEST_F(Relocation, strips_one_texel_wide_are_found) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 2500, .irregular = false});
  const int strips = 40;
  for (const double texels : {1.0, 2.0}) {
    cut(
        mesh, [&](double x, double) { return std::clamp(static_cast<int>(x * strips), 0, strips - 1); },
        [&](int chart, double x, double y) {
          return std::pair((20.3 + 12 * chart + (x * strips - chart) * texels) / 1024, 0.05 + 0.3 * y);
        });
    std::cout << texels << " texels wide\n";
    for (const int jumps : {8, 16}) {
      std::cout << jumps << " jumps\n";
      const Found result = found(mesh, with(affine, [&](Settings &s) {
                                   s.radius = 0.05;
                                   s.max_jumps = jumps;
                                 }));
      EXPECT_NEAR(result.mean_area(), 1, 0.02);
      EXPECT_GT(result.mean_coverage(), 0.98); // samples whose march meets the corner of a strip are lost
    }
  }
}

// A band of charts a third of a texel wide, none with a texel's center inside.
TEST_F(Relocation, charts_that_no_texel_carries_count_by_the_lines_of_their_edges) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 3000, .irregular = false});
  cut(
      mesh, [](double x, double y) { return x > 0.45 && x < 0.47 ? 1 + static_cast<int>(std::floor(y * 50)) : 0; },
      [](int chart, double x, double y) {
        if (chart == 0) return std::pair(0.05 + 0.9 * x, 0.05 + 0.45 * y);
        return std::pair((20.1 + 12 * chart + 0.3 * (x - 0.45) / 0.02) / 1024, (700.1 + 0.3 * (y * 50 + 1 - chart)) / 1024);
      });
  // The paper repeats its pattern on charts one jump away only.
  const Found marched = found(mesh, with(affine, [](Settings &s) { s.radius = 0.05; }));
  EXPECT_NEAR(marched.mean_area(), 1, 0.005);
  EXPECT_GT(marched.least_coverage(), 0.95);
  const Found one_jump = found(mesh, with(paper, [](Settings &s) { s.radius = 0.05; }));
  EXPECT_NEAR(one_jump.mean_area(), one_jump.mean_coverage(), 0.01);
  EXPECT_LT(one_jump.least_coverage(), 0.6);
}

// Combs that interlock: a straight way leaves its chart and enters it again, up to twice a tooth.
TEST_F(Relocation, charts_that_a_straight_way_leaves_and_enters_again_are_found) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 3000, .irregular = false});
  cut(
      mesh,
      [](double x, double y) {
        if (y < 0.2 || y >= 0.8) return y < 0.2 ? 0 : 1;
        return static_cast<int>(std::floor(x * 24)) % 2;
      },
      [](int chart, double x, double y) { return std::pair(0.03 + 0.45 * x + 0.48 * chart, 0.1 + 0.3 * y); });
  ASSERT_EQ(*std::ranges::max_element(mesh.triangle_chart), 1);
  expect_errors_below(2, mesh, with(affine, [](Settings &s) { s.radius = 0.06; }), "affine");
  const Found result = found(mesh, with(affine, [](Settings &s) { s.radius = 0.06; }));
  // Eight jumps are four teeth: more lie in the way of samples that run along the tube.
  EXPECT_GT(result.mean_coverage(), 0.99);
  EXPECT_GT(result.least_coverage(), 0.9);
  EXPECT_NEAR(result.mean_area(), 1, 0.01);
}

TEST_F(Relocation, a_thousand_charts_smaller_than_the_neighborhood_are_found) {
  const TestMesh mesh = torus_of(1000, 5000);
  double last = 0;
  for (const int jumps : {1, 2, 4, 8, 16}) {
    const Found result = found(mesh, with(affine, [&](Settings &s) { s.max_jumps = jumps; }));
    EXPECT_NEAR(result.mean_area(), result.mean_coverage(), 0.05) << jumps;
    EXPECT_GE(result.mean_coverage(), last) << jumps;
    last = result.mean_coverage();
  }
  EXPECT_GT(last, 0.99);
}

// The unit square with u = x^2: its length grows towards the left, where the ellipse of a center ends within the ball.
TEST_F(Relocation, the_directional_ellipse_finds_what_the_centers_distortion_leaves_out) {
  TestMesh mesh = plane(1, 1, {.vertices = 1500});
  cut(
      mesh, [](double, double) { return 0; },
      [](int, double x, double y) { return std::pair(0.02 + 0.9 * x * x, 0.02 + 0.9 * y); });
  Settings settings = with(affine, [](Settings &s) {
    s.radius = 0.12;
    s.radius_unit = PDESC_RADIUS_ABSOLUTE;
  });
  const std::vector<uint8_t> inside = interior(mesh, 0.12);
  settings.samples = 1024;
  const auto errors = [&](const Found &result) {
    double least = 1, largest = 1, sum = 0, count = 0;
    for (size_t v = 0; v < inside.size(); ++v)
      if (inside[v]) {
        least = std::min(least, result.area[v]);
        largest = std::max(largest, result.area[v]);
        sum += result.area[v];
        ++count;
      }
    std::cout << "areas from " << least << " to " << largest << ", mean " << sum / count << "\n";
    return std::array{least, largest, sum / count};
  };
  for (const int32_t relocation : {PDESC_RELOCATION_AFFINE, PDESC_RELOCATION_PAPER}) {
    settings.relocation = relocation;
    settings.ellipse = PDESC_ELLIPSE_CENTER;
    EXPECT_LT(errors(found(mesh, settings))[0], 0.95) << "what the center's ellipse leaves out";
    settings.ellipse = PDESC_ELLIPSE_DIRECTIONAL;
    const auto [least, largest, mean] = errors(found(mesh, settings));
    EXPECT_GT(least, 0.96);
    EXPECT_LT(largest, 1.04);
    EXPECT_NEAR(mean, 1, 0.01);
  }
}

// The stereographic map of the unit sphere, about a point of the equator: straight lines there have kappa_g = (n . e) with n
// across the way to the pole, and mean kappa_g^2 = 1/2. The sum of chords measures them, so that K comes out as 1.5.
TEST_F(Relocation, the_sum_of_chords_has_the_curvature_of_straight_lines_in_the_map) {
  // The patch is as wide as balls around the middle, whose size is half that at the pole.
  const auto patch = [](double middle, double width) {
    TestMesh mesh = plane(1, 1, {.vertices = 800, .irregular = false});
    for (size_t v = 0; v < mesh.points.size(); ++v) {
      const double x = middle + width * (mesh.parameters[v].x - 0.5), y = width * (mesh.parameters[v].y - 0.5),
                   square = x * x + y * y;
      mesh.points[v] = mesh.normals[v] = (1 / (1 + square)) * Vec3{2 * x, 2 * y, 1 - square}; // counterclockwise from outside
    }
    round_to_float(mesh);
    cut(
        mesh, [](double, double) { return 0; },
        [](int, double x, double y) { return std::pair(0.02 + 0.96 * x, 0.02 + 0.96 * y); });
    return mesh;
  };
  const std::string name = "gaussian_curvature";
  for (const auto &[middle, expected] : {std::pair(1.0, 1.5), std::pair(0.0, 1.0)}) { // equator; pole, whose lines are geodesics
    const TestMesh mesh = patch(middle, middle > 0 ? 0.9 : 0.45);
    const Vec3 center = (1 / (1 + middle * middle)) * Vec3{2 * middle, 0, 1 - middle * middle};
    for (const int32_t relocation : {PDESC_RELOCATION_AFFINE, PDESC_RELOCATION_PAPER})
      for (const int32_t geodesic : {PDESC_GEODESIC_LOCAL, PDESC_GEODESIC_CHORDS}) {
        if (relocation == PDESC_RELOCATION_PAPER && geodesic == PDESC_GEODESIC_LOCAL) continue; // no seams: the same samples
        Settings settings{.radius = 0.25, .radius_unit = PDESC_RADIUS_ABSOLUTE, .samples = 1024};
        settings.estimator = PDESC_ESTIMATOR_INTEGRAL;
        settings.relocation = relocation;
        settings.geodesic = geodesic;
        const Results results = compute(software.get(), mesh, settings, std::span(&name, 1));
        double sum = 0;
        int count = 0;
        for (size_t v = 0; v < mesh.points.size(); ++v)
          if (length(mesh.points[v] - center) < 0.08) {
            sum += static_cast<double>(results[name][v]);
            ++count;
          }
        ASSERT_GT(count, 10);
        std::cout << "K " << sum / count << " over " << count << " vertices\n";
        // O(r^2) of the estimator, and of kappa_g over 0.08 around the point.
        EXPECT_NEAR(sum / count, geodesic == PDESC_GEODESIC_LOCAL ? 1.0 : expected, 0.1);
      }
  }
}

} // namespace
} // namespace paradesc::test
