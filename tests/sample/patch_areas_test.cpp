// The area of the surface that is connected to a point within a ball, by patches: against disks and against floods over
// triangles.
#include "sample/patch_areas.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "sample/connected_triangles.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

struct Built {
  Triangles triangles;
  HalfEdges half_edges;
  Patches patches;

  explicit Built(const TestMesh &mesh)
      : triangles(read_triangles(input_of(mesh))), half_edges(build_half_edges(triangles)), patches(build_patches(half_edges)) {}

  std::vector<int32_t> all_points() const {
    std::vector<int32_t> points(static_cast<size_t>(half_edges.point_count));
    std::iota(points.begin(), points.end(), 0);
    return points;
  }
  std::vector<double> by_patches(std::span<const int32_t> points, double radius, int threads = 2) const {
    return PatchAreas(patches, half_edges, triangles, radius, threads).run(points);
  }
  std::vector<double> by_triangles(std::span<const int32_t> points, double radius) const {
    return ConnectedTriangleSearch(triangles, half_edges, radius, 100000, 2).run(points).area;
  }
};

// A sheet that is bent like a hairpin: two legs of length 4 and width 2, joined by half a cylinder of the given radius.
TestMesh hairpin(double bend) {
  TestMesh mesh = plane(2.0, 8.0 + pi * bend, {.vertices = 40000});
  for (Vec3 &point : mesh.points) {
    const double along = point.y; // from the middle of the bend
    const double over = std::max(std::abs(along) - 0.5 * pi * bend, 0.0), turn = (std::abs(along) - over) / bend;
    point = {point.x, -over + bend * std::cos(turn), (along < 0.0 ? -1.0 : 1.0) * bend * std::sin(turn)};
  }
  round_to_float(mesh);
  return mesh;
}

void expect_near(const std::vector<double> &found, const std::vector<double> &expected, double tolerance) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i], expected[i], tolerance) << "point " << i;
}

TEST(PatchAreas, on_a_plane_are_those_of_disks) {
  const TestMesh mesh = plane(2.0, 2.0, {.vertices = 20000});
  const Built built(mesh);
  const double r = 0.3, disk = pi * r * r;
  std::vector<int32_t> points;
  const std::vector<uint8_t> far = interior(mesh, r);
  for (const int32_t point : built.all_points())
    if (far[static_cast<size_t>(built.half_edges.point_vertex[static_cast<size_t>(point)])]) points.push_back(point);
  ASSERT_GT(points.size(), 5000u);
  expect_near(built.by_patches(points, r), std::vector<double>(points.size(), disk),
              0.02 * disk); // of 1400 vertices a rim of 130
}

TEST(PatchAreas, of_a_torus_are_those_of_its_triangles) {
  const Built built(torus(1.0, 0.4, {.vertices = 20000}));
  const double r = 0.4;
  const std::vector<int32_t> points = built.all_points();
  // Of 600 vertices in a ball some 80 lie at its rim, as chance has it. A bake asks for six hundredths.
  const std::vector<double> found = built.by_patches(points, r), expected = built.by_triangles(points, r);
  expect_near(found, expected, 0.04 * pi * r * r);
  double squares = 0.0;
  for (size_t i = 0; i < points.size(); ++i) squares += (found[i] - expected[i]) * (found[i] - expected[i]);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(points.size())), 0.01 * pi * r * r);
}

// Legs nearer to each other than patches are wide, and than the radius: the other one counts where the way around the bend leads
// through the ball alone.
TEST(PatchAreas, of_a_hairpin_leave_out_the_other_leg) {
  const double r = 0.3;
  for (const double bend : {0.02, 0.1}) {
    const Built built(hairpin(bend));
    const std::vector<int32_t> points = built.all_points();
    const std::vector<double> found = built.by_patches(points, r), expected = built.by_triangles(points, r);
    // Where the rim passes along the bend some vertices decide whether the other leg is reached.
    size_t other = 0, one_leg = 0, both = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      other += std::abs(found[i] - expected[i]) > 0.03 * pi * r * r;
      one_leg += expected[i] < 1.05 * pi * r * r;
      both += expected[i] > 1.2 * pi * r * r;
    }
    EXPECT_LE(other, points.size() / 500) << bend;
    EXPECT_GT(one_leg, points.size() / 2) << bend;
    EXPECT_GT(both, points.size() / 50) << bend;
  }
}

TEST(PatchAreas, do_not_depend_on_threads_or_on_company) {
  const Built built(hairpin(0.05));
  const double r = 0.3;
  const std::vector<int32_t> points = built.all_points();
  const std::vector<double> together = built.by_patches(points, r);
  EXPECT_EQ(together, built.by_patches(points, r, 1));
  for (size_t i = 0; i < points.size(); i += 997)
    EXPECT_NEAR(built.by_patches({&points[i], 1}, r)[0], together[i], 1e-5 * together[i])
        << i; // sums of floats, in another order
}

TEST(PatchAreas, are_not_known_where_triangles_are_large) {
  const Built built(torus(1.0, 0.4, {.vertices = 2000}));
  const std::vector<int32_t> points = built.all_points();
  for (const double area : built.by_patches(points, 0.08)) EXPECT_LT(area, 0.0);
}

// Positions far apart, a radius that floats round to nothing: no answer, but an end.
TEST(PatchAreas, end_where_the_radius_is_no_number_in_floats) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 200});
  scale(mesh, 1e17);
  round_to_float(mesh);
  const Built built(mesh);
  const std::vector<int32_t> points = built.all_points();
  EXPECT_EQ(built.by_patches(points, 1e-300).size(), points.size());
}

} // namespace
} // namespace paradesc::test
