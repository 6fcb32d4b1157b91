// Open boundaries: the neighborhood ends there, and the formulas take what is there. On a sphere nothing but the area changes;
// elsewhere a one-sided neighborhood is biased in proportion to its radius.
#include <algorithm>
#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/percent_ae.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;

class Boundary : public OnBackend {};
PDESC_ON_EACH_BACKEND(Boundary);

// A ball without the cap above z = height.
TestMesh open_ball(double height) {
  TestMesh mesh = sphere(1, {.vertices = 6000});
  std::vector<int32_t> kept, patches;
  for (size_t t = 0; t < mesh.triangle_patch.size(); ++t) {
    const auto z = [&](size_t corner) { return mesh.points[static_cast<size_t>(mesh.corner_vertices[3 * t + corner])].z; };
    if (std::max({z(0), z(1), z(2)}) > height) continue;
    for (size_t corner = 0; corner < 3; ++corner) kept.push_back(mesh.corner_vertices[3 * t + corner]);
    patches.push_back(mesh.triangle_patch[t]);
  }
  mesh.corner_vertices = kept;
  mesh.triangle_patch = patches;
  mesh.triangle_corners.resize(kept.size());
  round_to_float(mesh);
  return mesh;
}

// On a sphere n_i - n = d_i / R for every neighbor, and a_i depends on its distance alone: what is missing changes no mean over
// the neighbors' directions, at any radius. Exact normals. Chords of e leave e²/4 of H, twice that of squares; a facet lies (a² +
// b² + c²)/24 below the sphere on average, at most e²/8, which pi r² times over is missing from the volume.
TEST_P(Boundary, ball_with_a_hole_keeps_its_values_at_the_rim) {
  TestMesh mesh = open_ball(0.45);
  lay_out(mesh, {.charts = 6});
  const double e = longest_edge(mesh);
  const std::vector<std::string> names{"mean_curvature", "gaussian_curvature", "local_bending_energy", "sphere_volume_normalized",
                                       "euclidean_area"};
  const Results results = compute(context.get(), mesh, {.radius = 0.06, .normals = PDESC_NORMALS_MESH}, names);
  const double r = results.report.radius;
  std::vector<uint8_t> rim;
  int count = 0;
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    rim.push_back((results.mask[v] & PDESC_MASK_BOUNDARY) != 0 && (results.mask[v] & PDESC_MASK_NO_FACE) == 0);
    count += rim[v];
    // Whole triangles were cut off: the rim lies up to an edge, 0.1 at most, below the height.
    EXPECT_TRUE(!rim[v] || mesh.points[v].z > 0.45 - 1.2 * r - 0.1) << "vertex " << v << " is far from the hole";
  }
  ASSERT_GT(count, 100);
  expect_near(results["mean_curvature"], 1, e * e / 4, rim);
  expect_near(results["gaussian_curvature"], 1, e * e / 2, rim);
  expect_near(results["local_bending_energy"], 1, e * e / 2, rim);
  expect_near(results["sphere_volume_normalized"], 0.5 - 3 * r / 16, 0.75 * e * e / (8 * r), rim);
  // The existing area is less than the disk; euclidean_area_test.cpp explains the 4.5 %.
  for (size_t v = 0; v < rim.size(); ++v)
    EXPECT_TRUE(!rim[v] || results["euclidean_area"][v] < pi * r * r * 1.045) << "vertex " << v;
}

// The neighborhood's center of mass lies off p, so that the first derivative of curvature no longer cancels: half the radius,
// half the bias. 0.65: what is left of noise and of the second order.
TEST_P(Boundary, bias_of_a_cut_neighborhood_halves_with_the_radius) {
  TestMesh mesh = saddle(1, {.vertices = 8000});
  lay_out(mesh, {.charts = 6});
  const auto error = [&](double fraction) {
    const std::string name = "mean_curvature";
    const Results results =
        compute(context.get(), mesh, {.radius = fraction, .normals = PDESC_NORMALS_MESH}, std::span(&name, 1));
    std::vector<uint8_t> border;
    for (const double distance : mesh.boundary_distance) border.push_back(distance < 1e-9);
    const PercentAe found = percent_ae(results[name], mesh.H, border);
    EXPECT_GT(found.count, 200);
    return found.mean;
  };
  const double wide = error(0.04), narrow = error(0.02);
  std::cout << wide << " % at 4 %, " << narrow << " % at 2 % of the diagonal\n";
  EXPECT_GT(wide, 0.2) << "there is no bias to halve";
  EXPECT_LE(narrow, 0.65 * wide);
}

} // namespace
} // namespace paradesc::test
