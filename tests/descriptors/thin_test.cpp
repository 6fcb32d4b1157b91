// Surfaces that come near themselves: thin shells, folded sheets, parts that touch at a vertex or along an edge. Surface
// that is near in space but not connected within the ball does not count.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;
// Exact corner normals, so that the neighborhood alone is tested.
constexpr Settings settings{.normals = PDESC_NORMALS_MESH};

class Thin : public OnBackend {
protected:
  Results compute(const TestMesh &mesh, std::span<const std::string> names) {
    Results results = test::compute(context.get(), mesh, settings, names);
    radius = results.report.radius;
    return results;
  }
  // The tolerance on areas; euclidean_area_test.cpp says why.
  double area_tolerance() const { return GetParam() == PDESC_BACKEND_REFERENCE ? 2e-3 : 4.5e-2; }
};
PDESC_ON_EACH_BACKEND(Thin);

// Puts the second mesh beside the first: its UV map goes to the right half of the unit square, the first one's to the left.
TestMesh join(const TestMesh &a, const TestMesh &b) {
  TestMesh both = a;
  both.vertex_count += b.vertex_count;
  for (const int32_t vertex : b.corner_vertices) both.corner_vertices.push_back(vertex + a.vertex_count);
  for (size_t c = both.triangle_corners.size(); c < both.corner_vertices.size(); ++c)
    both.triangle_corners.push_back(static_cast<int32_t>(c));
  both.corner_uvs.insert(both.corner_uvs.end(), b.corner_uvs.begin(), b.corner_uvs.end());
  for (size_t i = 0; i < both.corner_uvs.size(); i += 2)
    both.corner_uvs[i] = both.corner_uvs[i] / 2 + (i < a.corner_uvs.size() ? 0.0f : 0.5f);
  both.points.insert(both.points.end(), b.points.begin(), b.points.end());
  both.normals.insert(both.normals.end(), b.normals.begin(), b.normals.end());
  both.H.insert(both.H.end(), b.H.begin(), b.H.end());
  both.boundary_distance.insert(both.boundary_distance.end(), b.boundary_distance.begin(), b.boundary_distance.end());
  round_to_float(both);
  return both;
}

void shift(TestMesh &mesh, Vec3 offset) {
  for (Vec3 &point : mesh.points) point = point + offset;
  round_to_float(mesh);
}

// Vertices of the two halves of a joined mesh that lie at the same float position.
int count_touching(const TestMesh &mesh, int32_t first_of_second) {
  int count = 0;
  const auto at = [&](int32_t vertex, int i) { return mesh.positions[static_cast<size_t>(3 * vertex + i)]; };
  for (int32_t a = 0; a < first_of_second; ++a)
    for (int32_t b = first_of_second; b < mesh.vertex_count; ++b)
      count += at(a, 0) == at(b, 0) && at(a, 1) == at(b, 1) && at(a, 2) == at(b, 2);
  return count;
}

// A shell of half the radius' thickness: 1/R on its outer side, -1/R on its inner one. Chords of 0.05 leave (0.05)²/4, below 0.1
// %.
TEST_P(Thin, shell_has_the_curvature_of_each_of_its_sides) {
  constexpr double inner_radius = 0.965;
  TestMesh outer = sphere(1, {.vertices = 6000}), inner = sphere(inner_radius, {.vertices = 6000, .seed = 2});
  turn_inside_out(inner);
  lay_out(outer, {.charts = 6});
  lay_out(inner, {.charts = 6});
  const TestMesh shell = join(outer, inner);
  const std::vector<std::string> names{"mean_curvature", "euclidean_area"};
  const Results results = compute(shell, names);
  ASSERT_LT(1 - inner_radius, 0.6 * radius);
  std::vector<uint8_t> outside(shell.points.size(), 0), inside(shell.points.size(), 1);
  for (size_t v = 0; v < outer.points.size(); ++v) std::swap(outside[v], inside[v]);
  expect_near(results["mean_curvature"], 1, 1e-3, outside);
  expect_near(results["mean_curvature"], -1 / inner_radius, 1e-3 / inner_radius, inside);
  const double disk = pi * radius * radius; // a cap of chord r has the disk's area
  expect_near(results["euclidean_area"], disk, disk * area_tolerance());
}

// A sheet bent back over itself at a third of the radius: away from the bend both leaves are planes that do not see each other,
// though one chart carries them both.
TEST_P(Thin, leaves_of_a_folded_sheet_do_not_see_each_other) {
  constexpr double bend = 0.01, length = 1.2; // radius of the bend; of the sheet along x
  TestMesh sheet = plane(length, 1, {.vertices = 12000});
  const double edge = longest_edge(sheet); // the triangles at the bend's ends reach that far over the leaves
  const double start = -pi * bend / 2;
  for (size_t v = 0; v < sheet.points.size(); ++v) {
    Vec3 &p = sheet.points[v];
    const double s = p.x - start, angle = std::min(std::max(s / bend, 0.0), pi);
    const double beyond = std::max(s - pi * bend, 0.0);
    p = {std::min(s, 0.0) + bend * std::sin(angle) - beyond, p.y, bend * (1 - std::cos(angle))};
    sheet.normals[v] = {-std::sin(angle), 0, std::cos(angle)};
  }
  round_to_float(sheet);
  lay_out(sheet, {.charts = 1});
  const std::vector<std::string> names{"mean_curvature", "euclidean_area", "sphere_volume_normalized"};
  const Results results = compute(sheet, names);
  ASSERT_LT(2 * bend, 0.9 * radius);
  std::vector<uint8_t> leaves = interior(sheet, 1.1 * radius);
  for (size_t v = 0; v < leaves.size(); ++v) leaves[v] = leaves[v] && sheet.points[v].x < -1.1 * radius - edge;
  const double disk = pi * radius * radius;
  expect_near(results["euclidean_area"], disk, disk * area_tolerance(), leaves);
  // Float positions of size 1 turn normals by 1e-6 over r: three times that over r, and of the ball's volume.
  expect_near(results["mean_curvature"], 0, 3e-6 / radius, leaves);
  expect_near(results["sphere_volume_normalized"], 0.5, 3e-6, leaves);
}

// Two balls with one common point, by position alone and as one vertex: each goes on being round there. Chords as above.
TEST_P(Thin, balls_that_touch_at_a_vertex_stay_round) {
  const Triangulation regular{.vertices = 6000, .irregular = false};
  TestMesh left = sphere(1, regular), right = sphere(1, regular);
  shift(right, {2, 0, 0});
  lay_out(left, {.charts = 6});
  lay_out(right, {.charts = 6});
  TestMesh pair = join(left, right);
  for (size_t v = 0; v < pair.points.size(); ++v) // rounding of x = 2 - 1 aside
    if (length(pair.points[v] - Vec3{1, 0, 0}) < 1e-9) pair.points[v] = {1, 0, 0};
  round_to_float(pair);
  ASSERT_EQ(count_touching(pair, left.vertex_count), 1);
  const std::vector<std::string> names{"mean_curvature"};
  expect_near(compute(pair, names)["mean_curvature"], 1, 1e-3);
  ASSERT_LT(radius, 0.2);

  int32_t common = -1;
  for (int32_t &vertex : pair.corner_vertices) {
    const bool touches = length(pair.points[static_cast<size_t>(vertex)] - Vec3{1, 0, 0}) < 1e-9;
    if (touches && common < 0) common = vertex;
    if (touches) vertex = common;
  }
  // The vertex itself belongs to both; its value is one ball's. Corner normals stay those of the ball that the corner is on.
  const Results shared = compute(pair, names);
  std::vector<uint8_t> used(pair.points.size(), 0);
  for (const int32_t vertex : pair.corner_vertices) used[static_cast<size_t>(vertex)] = 1;
  expect_near(shared["mean_curvature"], 1, 1e-3, used);
}

// Two pipes side by side, with a common line of edges that four faces meet in. 5e-3: mean_curvature_test.cpp says why.
TEST_P(Thin, pipes_that_touch_along_edges_stay_round) {
  const Triangulation regular{.vertices = 8000, .irregular = false};
  TestMesh left = cylinder(0.5, 2, regular), right = cylinder(0.5, 2, regular);
  shift(right, {1, 0, 0});
  lay_out(left, {.charts = 6});
  lay_out(right, {.charts = 6});
  TestMesh pair = join(left, right);
  for (Vec3 &p : pair.points)
    if (std::abs(p.x - 0.5) < 1e-9 && std::abs(p.y) < 1e-9) p = {0.5, 0, p.z};
  round_to_float(pair);
  ASSERT_GT(count_touching(pair, left.vertex_count), 20);
  const Mesh created = make_mesh(context.get(), pair);
  pdesc_mesh_report report;
  pdesc_mesh_report_init(&report);
  ASSERT_EQ(pdesc_mesh_get_report(created.get(), &report), PDESC_OK);
  EXPECT_EQ(report.parts, 2);
  const std::vector<std::string> names{"mean_curvature"};
  const Results results = compute(pair, names);
  expect_near(results["mean_curvature"], 1, 5e-3, interior(pair, 1.1 * radius));
}

} // namespace
} // namespace paradesc::test
