// Sheets near each other that are one surface elsewhere, by the engine on the CPU.
#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/oracle.h"
#include "support/run.h"

namespace paradesc::test {
namespace {

constexpr double pi = std::numbers::pi;

class NearSheets : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    context = open_context(PDESC_BACKEND_CPU, why_not);
    ASSERT_TRUE(context);
  }

  // Expects that vertices for which chosen(vertex) is true, and which no boundary is near, have the oracle's area: that of a
  // disk, but for half a per cent that facets of a ramp leave.
  void expect_the_oracles_areas(const TestMesh &mesh, double radius, const std::function<bool(size_t)> &chosen) {
    const std::string area = "euclidean_area";
    const Settings settings{.radius = radius, .radius_unit = PDESC_RADIUS_ABSOLUTE};
    const Results found = compute(context.get(), mesh, settings, std::span(&area, 1));
    std::vector<int32_t> vertices;
    for (size_t v = 0; v < mesh.points.size(); v += 4) // some hundred
      if (chosen(v)) vertices.push_back(static_cast<int32_t>(v));
    const Oracle oracle = ask_oracle(mesh, radius, settings, vertices, std::span(&area, 1));
    const double disk = pi * radius * radius;
    double worst = 0;
    int count = 0;
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (oracle.boundary[i]) continue;
      const auto v = static_cast<size_t>(vertices[i]);
      ++count;
      worst = std::max(worst, std::abs(static_cast<double>(found[area][v]) - oracle[area][i]) / disk);
    }
    std::cout << "worst " << worst << " of the disk over " << count << " vertices\n";
    EXPECT_GT(count, 100);
    EXPECT_LT(worst, 0.01);
  }

  Context context;
};

// A ramp around a pole; floors lie `height` above each other.
TestMesh ramp_around_pole(double inner, double outer, double height, double turns) {
  TestMesh ramp = plane(1, 1, {.vertices = 16000, .irregular = false});
  for (size_t v = 0; v < ramp.points.size(); ++v) {
    const double angle = 2 * pi * turns * ramp.parameters[v].y, away = inner + (outer - inner) * ramp.parameters[v].x;
    ramp.points[v] = {away * std::cos(angle), away * std::sin(angle), height * turns * ramp.parameters[v].y};
    ramp.normals[v] = normalized({height / (2 * pi) * std::sin(angle), -height / (2 * pi) * std::cos(angle), away});
  }
  ramp.lengths = {outer - inner, pi * (outer + inner) * turns, 1};
  round_to_float(ramp);
  lay_out(ramp, {.charts = 8});
  return ramp;
}

// The pole is outside of the balls: the floors above and below face the same way, and are connected around the pole.
TEST_F(NearSheets, floors_of_a_ramp_that_face_alike_do_not_see_each_other) {
  constexpr double radius = 0.3;
  const TestMesh ramp = ramp_around_pole(0.06, 1, 0.12, 4);
  expect_the_oracles_areas(ramp, radius, [&](size_t v) {
    const double away = std::hypot(ramp.points[v].x, ramp.points[v].y);
    return away > 1.02 * radius && away < 1.6 * radius;
  });
}

// The floors above and below have a tenth of a disk each in the ball: all there face one way, and have hardly more area than
// one sheet may have.
TEST_F(NearSheets, floors_that_only_just_reach_into_a_ball_are_not_seen_in_it) {
  constexpr double radius = 0.2;
  const TestMesh ramp = ramp_around_pole(0.06, 1, 0.95 * radius, 3);
  expect_the_oracles_areas(ramp, radius, [&](size_t v) {
    const double away = std::hypot(ramp.points[v].x, ramp.points[v].y);
    return away > 2 * radius && away < 3.5 * radius;
  });
}

// Two leaves that are connected around a bend between one and two radii away, which runs across the axes.
TEST_F(NearSheets, leaves_that_meet_beyond_the_ball_do_not_see_each_other) {
  constexpr double bend = 0.015, radius = 0.1;
  TestMesh sheet = plane(1.2, 0.8, {.vertices = 12000, .irregular = false});
  std::vector<double> away; // from the bend
  for (size_t v = 0; v < sheet.points.size(); ++v) {
    Vec3 &p = sheet.points[v];
    const double s = p.x, angle = std::min(std::max(s / bend, 0.0), pi), beyond = std::max(s - pi * bend, 0.0);
    p = {std::min(s, 0.0) + bend * std::sin(angle) - beyond, p.y, bend * (1 - std::cos(angle))};
    sheet.normals[v] = {-std::sin(angle), 0, std::cos(angle)};
    away.push_back(-p.x);
  }
  rotate(sheet, rotation_about({0, 0, 1}, pi / 4));
  lay_out(sheet, {.charts = 1});
  expect_the_oracles_areas(sheet, radius, [&](size_t v) { return away[v] > 1.05 * radius && away[v] < 2.5 * radius; });
}

} // namespace
} // namespace paradesc::test
