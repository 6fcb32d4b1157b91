// Pieces of triangles: a mesh like that which was divided, as fine as was asked for, whose places are found again.
#include "mesh/division.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "bake/shapes.h"
#include "support/checkpoints.h"

namespace paradesc::test {
namespace {

// Lengths in space alone, in units of `unit`.
MeasureTriangle in_space(const Triangles &triangles, float unit) {
  return [&triangles, unit](int32_t triangle) {
    const auto position = [&](int32_t k) { return triangles.position(3 * triangle + k) / unit; };
    const vec3 far_apart(1e3f);
    return TriangleMeasure{vec2(far_apart), vec2(-1e3f, 1e3f), position(1) - position(0), position(2) - position(0)};
  };
}

// Lengths without any sense, which differ from triangle to triangle.
MeasureTriangle by_chance(uint32_t seed) {
  return [seed](int32_t triangle) {
    Random random(seed + static_cast<uint32_t>(triangle));
    const auto some = [&] { return static_cast<float>(std::max(3 * random.normal(), 0.0)); };
    return TriangleMeasure{{some(), some()}, {some(), -some()}, {some(), some(), 0.0f}, {some(), 0.0f, some()}};
  };
}

struct Divided {
  Built built;
  Division division;
  Divided(Triangles triangles, const std::function<MeasureTriangle(const Triangles &)> &measure, int threads = 2) {
    built = build(std::move(triangles));
    division = divide(built.half_edges, plan_division(built.half_edges, measure(built.triangles), 1 << 20, threads), threads);
  }
  explicit Divided(const TestMesh &mesh, uint32_t seed)
      : Divided(read_triangles(input_of(mesh)), [&](const Triangles &) { return by_chance(seed); }) {}

  // Returns the position of a fan's place in its triangle.
  dvec3 place(int32_t triangle, vec2 weights) const {
    const auto corner = [&](int k) { return dvec3(built.triangles.position(3 * triangle + k)); };
    return corner(0) + (corner(1) - corner(0)) * static_cast<double>(weights.x) +
           (corner(2) - corner(0)) * static_cast<double>(weights.y);
  }
  vec2 weights(int32_t corner) const { return division.fan_weights[at((*division.corner_fan)[at(corner)])]; }
};

// Each point has one fan that its half-edge leads around; twins have the same two points; nothing but the boundary is open.
void expect_sound(const HalfEdges &pieces) {
  const auto corners = static_cast<int32_t>(pieces.twin.size());
  std::vector<int> around(at(pieces.point_count), 0);
  for (int32_t h = 0; h < corners; ++h) {
    const int32_t twin = pieces.twin[at(h)];
    ++around[at(pieces.corner_point[at(h)])];
    if (twin < 0) continue;
    ASSERT_EQ(pieces.twin[at(twin)], h);
    ASSERT_EQ(pieces.corner_point[at(h)], pieces.corner_point[at(next_corner(twin))]);
    ASSERT_EQ(pieces.corner_point[at(next_corner(h))], pieces.corner_point[at(twin)]);
  }
  for (int32_t point = 0; point < pieces.point_count; ++point) {
    const int32_t first = pieces.point_half_edge[at(point)];
    ASSERT_GE(first, 0);
    int reached = 0;
    for (int32_t corner = first; corner >= 0;) {
      ASSERT_EQ(pieces.corner_point[at(corner)], point);
      ++reached;
      corner = pieces.twin[at(previous_corner(corner))];
      if (corner == first) break;
    }
    ASSERT_EQ(reached, around[at(point)]) << "of point " << point;
    ASSERT_EQ(pieces.point_boundary[at(point)] != 0, pieces.twin[at(first)] < 0);
  }
}

int euler(const HalfEdges &mesh) {
  int edges = 0;
  for (size_t h = 0; h < mesh.twin.size(); ++h)
    edges += mesh.corner_point[h] >= 0 && (mesh.twin[h] < 0 || mesh.twin[h] > static_cast<int32_t>(h));
  int triangles = 0;
  for (size_t h = 0; h < mesh.twin.size(); h += 3) triangles += mesh.corner_point[h] >= 0;
  return mesh.point_count - edges + triangles;
}

// Whatever the lengths are.
void expect_divided_soundly(const TestMesh &mesh, uint32_t seed) {
  const Divided of(mesh, seed);
  const HalfEdges &base = of.built.half_edges, &pieces = of.division.half_edges;
  EXPECT_GT(pieces.twin.size(), 3 * base.twin.size());
  expect_sound(pieces);
  EXPECT_EQ(euler(pieces), euler(base));
  for (int32_t triangle = 0; triangle < of.built.triangles.triangle_count; ++triangle) {
    const int32_t first = of.division.plan.piece_begin[at(triangle)], last = of.division.plan.piece_begin[at(triangle) + 1];
    if (base.corner_point[at(3 * triangle)] < 0) {
      EXPECT_EQ(first, last) << "it was left out";
      continue;
    }
    double area = 0; // of the whole
    for (int32_t piece = first; piece < last; ++piece) {
      EXPECT_EQ(pieces.triangle_piece[at(piece)], base.triangle_piece[at(triangle)]);
      const dvec2 a(of.weights(3 * piece)), b(of.weights(3 * piece + 1)), c(of.weights(3 * piece + 2));
      const double part = paradesc::cross(b - a, c - a);
      ASSERT_GT(part, 0) << "wound the same way";
      area += part;
    }
    ASSERT_NEAR(area, 1, 1e-12) << "halves are exact";
  }
}

TEST(Division, of_a_closed_surface_is_closed_and_of_one_with_rims_has_these) {
  expect_divided_soundly(torus(1, 0.4, {.vertices = 300}), 1);
  expect_divided_soundly(sphere(1, {.vertices = 40}), 2);
  expect_divided_soundly(plane(2, 2, {.vertices = 100}), 3);
}

TEST(Division, of_triangles_that_touch_at_points_or_have_no_area_keeps_them_apart) {
  TestMesh two = sphere(1, {.vertices = 40});
  two.corner_vertices[4] = two.corner_vertices[3]; // no area, and a hole
  expect_divided_soundly(two, 4);
}

// Points on edges are where both triangles have them, and the mesh's points are the first.
TEST(Division, has_each_point_at_one_place) {
  const Divided of(torus(1, 0.4, {.vertices = 300}), 5);
  std::map<int32_t, dvec3> places;
  for (int32_t triangle = 0; triangle < of.built.triangles.triangle_count; ++triangle)
    for (int32_t h = 3 * of.division.plan.piece_begin[at(triangle)]; h < 3 * of.division.plan.piece_begin[at(triangle) + 1];
         ++h) {
      const dvec3 place = of.place(triangle, of.weights(h));
      const auto [found, is_new] = places.emplace(of.division.half_edges.corner_point[at(h)], place);
      ASSERT_LT(glm::length(found->second - place), 1e-12); // rounding of doubles
    }
  EXPECT_EQ(static_cast<int>(places.size()), of.division.half_edges.point_count);
  for (int32_t point = 0; point < of.built.half_edges.point_count; ++point)
    EXPECT_EQ(places.at(point), dvec3(of.built.triangles.positions[at(of.built.half_edges.point_vertex[at(point)])]));
}

TEST(Division, is_as_fine_as_was_asked_for_and_not_much_finer) {
  constexpr float unit = 0.03f;
  const Divided of(read_triangles(input_of(torus(1, 0.4, {.vertices = 300}))),
                   [](const Triangles &triangles) { return in_space(triangles, unit); });
  double sum = 0;
  int count = 0;
  for (int32_t triangle = 0; triangle < of.built.triangles.triangle_count; ++triangle)
    for (int32_t h = 3 * of.division.plan.piece_begin[at(triangle)]; h < 3 * of.division.plan.piece_begin[at(triangle) + 1];
         ++h) {
      const double edge = glm::length(of.place(triangle, of.weights(h)) - of.place(triangle, of.weights(next_corner(h))));
      ASSERT_LT(edge, 1.0001 * static_cast<double>(unit)); // lengths are floats
      sum += edge;
      ++count;
    }
  EXPECT_GT(sum / count, 0.5 * static_cast<double>(unit)) << "an edge that is halved was longer than the unit";
}

TEST(Division, finds_places_again) {
  const Divided of(torus(1, 0.4, {.vertices = 100}), 6);
  Random random(7);
  int moved = 0;
  for (int i = 0; i < 5000; ++i) {
    const auto triangle = static_cast<int32_t>(i % of.built.triangles.triangle_count);
    double a = random.uniform(), b = random.uniform();
    if (a + b > 1) a = 1 - a, b = 1 - b;
    const vec2 weights(a, b);
    const TrianglePlace place = of.division.at({triangle, weights});
    ASSERT_GE(place.triangle, of.division.plan.piece_begin[at(triangle)]);
    ASSERT_LT(place.triangle, of.division.plan.piece_begin[at(triangle) + 1]);
    ASSERT_GE(std::min({place.weights.x, place.weights.y, 1 - place.weights.x - place.weights.y}), -1e-4f);
    const auto corner = [&](int k) { return of.place(triangle, of.weights(3 * place.triangle + k)); };
    const dvec3 found = corner(0) + (corner(1) - corner(0)) * static_cast<double>(place.weights.x) +
                        (corner(2) - corner(0)) * static_cast<double>(place.weights.y);
    ASSERT_LT(glm::length(found - of.place(triangle, weights)), 1e-6); // weights are floats
    moved += place.weights != weights;
  }
  EXPECT_GT(moved, 1000);
}

TEST(Division, of_what_is_short_enough_is_the_mesh_itself) {
  const Divided of(read_triangles(input_of(torus(1, 0.4, {.vertices = 300}))),
                   [](const Triangles &triangles) { return in_space(triangles, 10.0f); });
  EXPECT_EQ(of.division.half_edges.corner_point, of.built.half_edges.corner_point);
  EXPECT_EQ(of.division.half_edges.twin, of.built.half_edges.twin);
  EXPECT_EQ(of.division.plan.coarsening, 1.0f);
  const TrianglePlace same = of.division.at({5, vec2(0.25f, 0.5f)});
  EXPECT_EQ(same.triangle, 5);
  EXPECT_EQ(same.weights, vec2(0.25f, 0.5f));
}

TEST(Division, has_no_more_pieces_than_allowed_and_at_least_the_triangles) {
  const Built built = build(read_triangles(input_of(torus(1, 0.4, {.vertices = 300}))));
  const MeasureTriangle measure = in_space(built.triangles, 0.001f);
  for (const int32_t most : {10, 5000, 50000}) {
    const DivisionPlan plan = plan_division(built.half_edges, measure, most, 2);
    EXPECT_LE(plan.pieces(), std::max(most, built.triangles.triangle_count));
    EXPECT_GE(plan.pieces(), std::max(most / 4, built.triangles.triangle_count)); // halving edges makes four of one
    EXPECT_GT(plan.coarsening, 1.0f);
    expect_sound(divide(built.half_edges, plan, 2).half_edges);
  }
}

// One of these triangles can have a million pieces, of images of any size; all that is done about it goes with the limit. There
// is a checkpoint each 1024 pieces of a triangle.
TEST(Division, of_a_large_map_on_large_triangles_is_planned_by_few_times_as_many_pieces_as_are_allowed) {
  const Built built = build(read_triangles(input_of(sphere(1, {.vertices = 8}))));
  constexpr int32_t most = 1 << 15;
  for (const float pixels : {2e3f, 8e3f, 6e4f}) {
    const MeasureTriangle measure = [&](int32_t) {
      return TriangleMeasure{vec2(pixels, 0.0f), vec2(0.0f, pixels), vec3(1e9f, 0.0f, 0.0f), vec3(0.0f, 1e9f, 0.0f)};
    };
    DivisionPlan plan;
    const int checkpoints = checkpoints_of([&] { plan = plan_division(built.half_edges, measure, most, 1); });
    EXPECT_LE(plan.pieces(), most);
    EXPECT_GE(plan.pieces(), most / 4);
    EXPECT_GE(checkpoints, plan.pieces() / 1024) << "or they are no measure of the work";
    EXPECT_LE(checkpoints, 4 * most / 1024 + 20) << "four counts, with loops over a dozen triangles; " << pixels << " pixels";
  }
}

// For example, no float may hold the size of an image times a (u, v).
TEST(Division, ends_where_lengths_are_no_numbers) {
  const Built built = build(read_triangles(input_of(sphere(1, {.vertices = 40}))));
  const MeasureTriangle measure = [](int32_t) {
    return TriangleMeasure{vec2(3e38f), vec2(-3e38f), vec3(1e30f), vec3(std::numeric_limits<float>::infinity())};
  };
  EXPECT_LE(plan_division(built.half_edges, measure, 1 << 16, 2).pieces(), 1 << 16);
}

TEST(Division, follows_space_alone_where_an_image_is_no_number) {
  const Built built = build(read_triangles(input_of(sphere(1, {.vertices = 40}))));
  const auto pieces = [&](float image) {
    const MeasureTriangle measure = [image](int32_t) {
      return TriangleMeasure{vec2(-6.5f, image), vec2(-6.5f, image), vec3(46.0f, 36.0f, 14.0f), vec3(19.0f, 35.0f, -95.0f)};
    };
    return plan_division(built.half_edges, measure, 1 << 20, 2).pieces();
  };
  EXPECT_EQ(pieces(-std::numeric_limits<float>::infinity()), pieces(1e9f));
}

// Found by fuzzing: a piece whose lengths are but the rounding of far larger ones has a side that nothing cuts off.
TEST(Division, ends_where_a_triangle_spans_an_image_many_times_over) {
  const Built built = build(read_triangles(input_of(sphere(1, {.vertices = 40}))));
  const MeasureTriangle measure = [](int32_t) {
    return TriangleMeasure{vec2(1.6f, 1.14387e13f), vec2(0.0f, 1.14387e13f), vec3(35.9045f, 35.9045f, 3.77942f),
                           vec3(0.0f, 35.9045f, 3.77942f)};
  };
  expect_sound(divide(built.half_edges, plan_division(built.half_edges, measure, 1 << 20, 2), 2).half_edges);
}

// Sides are halved ten times at most, so parts of these would stay long.
// Each side is short in space or in the image, so that a cut is longer than all of them.
TEST(Division, ends_where_a_cut_is_longer_than_any_side) {
  const Built built = build(read_triangles(input_of(sphere(1, {.vertices = 40}))));
  const MeasureTriangle measure = [](int32_t) {
    return TriangleMeasure{vec2(60000.0f, 0.0f), vec2(60000.0f, 2000.0f), vec3(2000.0f, 0.0f, 0.0f), vec3(-2000.0f, 0.0f, 0.0f)};
  };
  expect_sound(divide(built.half_edges, plan_division(built.half_edges, measure, 1 << 20, 2), 2).half_edges);
}

// Along one way what is so long in space cancels out, but for what floats have lost.
TEST(Division, ends_where_a_triangle_is_far_larger_than_its_image) {
  const Built built = build(read_triangles(input_of(sphere(1, {.vertices = 40}))));
  const MeasureTriangle measure = [](int32_t) {
    return TriangleMeasure{vec2(8.8359375f, 2.9453125f), vec2(0.0f, 2.9453125f), vec3(-27557888.0f, -0.60229677f, -0.60229677f),
                           vec3(-13778944.0f, 0.0f, -0.60229677f)};
  };
  expect_sound(divide(built.half_edges, plan_division(built.half_edges, measure, 1 << 20, 2), 2).half_edges);
}

// Some of these triangles are a point in space or in the image along one way, and far larger than the other along another.
TEST(Division, ends_whatever_lengths_are) {
  const Built built = build(read_triangles(input_of(sphere(1, {.vertices = 40}))));
  for (uint32_t seed = 0; seed < 50; ++seed) {
    const MeasureTriangle measure = [seed](int32_t triangle) {
      Random random(1000 * seed + static_cast<uint32_t>(triangle));
      const auto some = [&] { return static_cast<float>(random.normal() * std::pow(10.0, 4.0 * random.normal())); };
      const vec2 image(some(), some());
      const vec3 space(some(), some(), some());
      const float part = static_cast<float>(random.normal());
      return TriangleMeasure{image, part * image + vec2(0.0f, some()), space, part * space + vec3(0.0f, 0.0f, 1.0f)};
    };
    EXPECT_LE(plan_division(built.half_edges, measure, 1 << 12, 2).pieces(), 1 << 12) << "seed " << seed;
  }
}

TEST(Division, ends_where_edges_are_longer_than_halving_makes_short) {
  const Built built = build(read_triangles(input_of(sphere(1, {.vertices = 8}))));
  const DivisionPlan plan = plan_division(built.half_edges, in_space(built.triangles, 1e-6f), 1 << 16, 2);
  EXPECT_LE(plan.pieces(), 1 << 16);
  EXPECT_GE(plan.pieces(), 1 << 12);
}

TEST(Division, does_not_depend_on_threads) {
  const Triangles triangles = read_triangles(input_of(torus(1, 0.4, {.vertices = 2000})));
  const auto divided = [&](int threads) {
    return Divided(
        triangles, [](const Triangles &) { return by_chance(8); }, threads);
  };
  const Divided one = divided(1), three = divided(3);
  EXPECT_EQ(one.division.half_edges.corner_point, three.division.half_edges.corner_point);
  EXPECT_EQ(one.division.half_edges.twin, three.division.half_edges.twin);
  EXPECT_EQ(*one.division.corner_fan, *three.division.corner_fan);
  EXPECT_EQ(one.division.fan_weights, three.division.fan_weights);
  EXPECT_EQ(one.division.tree, three.division.tree);
  EXPECT_TRUE(one.division.plan == three.division.plan);
}

} // namespace
} // namespace paradesc::test
