// Validation of the caller's arrays, the map into the unit square, sharp half-edges.
#include "mesh/triangles.h"

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "support/error.h"

namespace paradesc {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

// A unit square of two triangles, (0, 1, 2) and (0, 2, 3), with four shared corners; its UVs are its x and y.
struct Square {
  std::vector<float> positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  std::vector<int32_t> corner_vertices = {0, 1, 2, 3};
  std::vector<int32_t> triangle_corners = {0, 1, 2, 0, 2, 3};
  std::vector<float> uvs = {0, 0, 1, 0, 1, 1, 0, 1};
  std::vector<float> normals = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  std::vector<uint8_t> smooth = {1, 1};
  std::vector<int32_t> sharp;

  pdesc_mesh_input input() const {
    pdesc_mesh_input result{};
    result.struct_size = sizeof result;
    result.vertex_count = static_cast<int32_t>(positions.size() / 3);
    result.corner_count = static_cast<int32_t>(corner_vertices.size());
    result.triangle_count = static_cast<int32_t>(triangle_corners.size() / 3);
    result.positions = positions.data();
    result.corner_vertices = corner_vertices.data();
    result.triangle_corners = triangle_corners.data();
    result.corner_uvs = uvs.data();
    result.corner_normals = normals.data();
    result.triangle_smooth = smooth.data();
    result.sharp_edges = sharp.empty() ? nullptr : sharp.data();
    result.sharp_edge_count = static_cast<int32_t>(sharp.size() / 2);
    return result;
  }
};

std::string sentence_of(const std::function<void()> &call) {
  try {
    call();
  } catch (const Error &error) {
    EXPECT_EQ(error.status(), PDESC_ERROR_INVALID_ARGUMENT);
    return error.what();
  }
  return "accepted";
}

std::string refusal(const pdesc_mesh_input &input) {
  return sentence_of([&] { read_triangles(input); });
}

std::string refusal(const Square &square) { return refusal(square.input()); }

std::string refusal(const std::function<void(pdesc_mesh_input &)> &spoil) {
  const Square square;
  pdesc_mesh_input input = square.input();
  spoil(input);
  return refusal(input);
}

// Sentences are read by people, so tests hold to what was found, where, and what to do; not to every word.
testing::AssertionResult says(const std::string &sentence, std::initializer_list<const char *> parts) {
  for (const char *part : parts)
    if (sentence.find(part) == std::string::npos)
      return testing::AssertionFailure() << "\"" << sentence << "\" does not say \"" << part << "\"";
  return testing::AssertionSuccess();
}

TEST(Triangles, a_sound_mesh_is_copied_corner_by_corner) {
  const Square square;
  const Triangles triangles = read_triangles(square.input());
  EXPECT_EQ(triangles.vertex_count, 4);
  EXPECT_EQ(triangles.triangle_count, 2);
  EXPECT_EQ(triangles.corner_vertex, (std::vector<int32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(triangles.positions, (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(triangles.corner_uv, (std::vector<vec2>{{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}));
  EXPECT_EQ(triangles.corner_normal, std::vector<vec3>(6, vec3(0, 0, 1)));
  EXPECT_EQ(triangles.half_edge_sharp, std::vector<uint8_t>(6, 0));
  EXPECT_FALSE(triangles.uv_remapped);
}

TEST(Triangles, uvs_and_normals_may_be_missing) {
  const Square square;
  pdesc_mesh_input input = square.input();
  input.corner_uvs = input.corner_normals = nullptr;
  input.triangle_smooth = nullptr;
  const Triangles triangles = read_triangles(input);
  EXPECT_TRUE(triangles.corner_uv.empty());
  EXPECT_TRUE(triangles.corner_normal.empty());
  EXPECT_EQ(triangles.half_edge_sharp.size(), 6u);
}

TEST(Triangles, a_mesh_without_faces_is_refused_whatever_else_is_given) {
  const pdesc_mesh_input nothing{};
  EXPECT_TRUE(says(refusal(nothing), {"no faces", "at least one triangle"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.triangle_count = 0; }), {"no faces"}));
}

TEST(Triangles, counts_that_cannot_be_are_named) {
  EXPECT_TRUE(says(refusal([](auto &input) { input.triangle_count = -2; }), {"triangle count", "-2"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.triangle_count = 2000000000; }), {"2000000000", "at most 715827882"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.vertex_count = 0; }), {"vertex count", "0"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.vertex_count = -1; }), {"vertex count", "-1"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.corner_count = 0; }), {"corner count", "0"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.sharp_edge_count = -3; }), {"sharp edge count", "-3"}));
}

TEST(Triangles, missing_arrays_are_named) {
  EXPECT_TRUE(says(refusal([](auto &input) { input.positions = nullptr; }), {"positions is NULL", "4 vertices"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.corner_vertices = nullptr; }), {"corner_vertices is NULL", "4 corners"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.triangle_corners = nullptr; }), {"triangle_corners is NULL", "2 triangles"}));
  EXPECT_TRUE(says(refusal([](auto &input) { input.sharp_edge_count = 5; }), {"sharp_edges is NULL", "5"}));
}

TEST(Triangles, an_index_out_of_range_is_named_with_its_place) {
  Square square;
  square.triangle_corners[4] = 4;
  EXPECT_TRUE(says(refusal(square), {"Triangle 1", "corner 4", "from 0 to 3"}));
  square = {};
  square.triangle_corners[0] = -1;
  EXPECT_TRUE(says(refusal(square), {"Triangle 0", "corner -1"}));
  square = {};
  square.corner_vertices[3] = 7;
  EXPECT_TRUE(says(refusal(square), {"Corner 3", "vertex 7", "from 0 to 3"}));
  square = {};
  square.sharp = {0, 1, 2, 4};
  EXPECT_TRUE(says(refusal(square), {"Sharp edge 1", "vertex 4", "from 0 to 3"}));
}

TEST(Triangles, a_coordinate_that_is_not_finite_is_named_with_its_place) {
  Square square;
  square.positions[3 * 2 + 1] = nan;
  EXPECT_TRUE(says(refusal(square), {"The y of vertex 2", "nan", "finite"}));
  square = {};
  square.positions[3 * 3 + 2] = -infinity;
  EXPECT_TRUE(says(refusal(square), {"The z of vertex 3", "-inf", "finite"}));
  square = {};
  square.uvs[2 * 1 + 1] = infinity;
  EXPECT_TRUE(says(refusal(square), {"The v of corner 1", "inf", "finite UV"}));
  square = {};
  square.normals[0] = nan;
  EXPECT_TRUE(says(refusal(square), {"The x of the normal of corner 0", "nan"}));
}

TEST(Triangles, a_coordinate_too_large_to_square_is_refused) {
  Square square;
  square.positions[0] = 2e18f;
  EXPECT_TRUE(says(refusal(square), {"The x of vertex 0", "2e+18", "1e+18", "scale"}));
  square.positions[0] = -1e18f;
  EXPECT_EQ(refusal(square), "accepted");
}

TEST(Triangles, new_positions_are_checked_like_the_first) {
  const Square square;
  Triangles triangles = read_triangles(square.input());
  std::vector<float> positions = square.positions;
  for (float &x : positions) x += 2;
  set_positions(triangles, positions.data(), 4);
  EXPECT_EQ(triangles.positions[2], vec3(3, 3, 2));
  positions[5] = nan;
  EXPECT_TRUE(says(sentence_of([&] { set_positions(triangles, positions.data(), 4); }), {"The z of vertex 1", "nan"}));
  EXPECT_TRUE(says(sentence_of([&] { set_positions(triangles, positions.data(), 3); }), {"3 vertices", "has 4"}));
  EXPECT_TRUE(says(sentence_of([&] { set_positions(triangles, nullptr, 4); }), {"positions is NULL"}));
  EXPECT_EQ(triangles.positions[2], vec3(3, 3, 2)) << "a refused call changed the mesh";
}

// The UVs of the square after reading, in order of its four corners.
std::vector<vec2> read_uvs(const std::vector<float> &uvs, bool expect_remapped) {
  Square square;
  square.uvs = uvs;
  const Triangles triangles = read_triangles(square.input());
  EXPECT_EQ(triangles.uv_remapped, expect_remapped);
  for (const vec2 &uv : triangles.corner_uv) EXPECT_TRUE(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1) << uv.x << " " << uv.y;
  return {triangles.corner_uv[0], triangles.corner_uv[1], triangles.corner_uv[2], triangles.corner_uv[5]};
}

void expect_near(vec2 a, vec2 b) {
  EXPECT_NEAR(a.x, b.x, 1e-7); // a float's rounding below 1
  EXPECT_NEAR(a.y, b.y, 1e-7);
}

TEST(Triangles, uvs_within_the_unit_square_are_untouched) {
  const std::vector<vec2> uvs = read_uvs({0.1f, 0.2f, 0.3f, 0.2f, 0.3f, 0.4f, 0.1f, 0.4f}, false);
  EXPECT_EQ(uvs, (std::vector<vec2>{{0.1f, 0.2f}, {0.3f, 0.2f}, {0.3f, 0.4f}, {0.1f, 0.4f}}));
}

TEST(Triangles, uvs_a_little_outside_are_scaled_by_no_more_than_needed) {
  const std::vector<vec2> uvs = read_uvs({0, 0, 1.00065f, 0, 1.00065f, 0.5f, 0, 0.5f}, true);
  expect_near(uvs[0], {0, 0});
  expect_near(uvs[2], {1, 0.5f / 1.00065f});
}

TEST(Triangles, a_layout_that_fits_is_moved_but_keeps_its_size) {
  const std::vector<vec2> uvs = read_uvs({-0.25f, 0.5f, 0.25f, 0.5f, 0.25f, 0.75f, -0.25f, 0.75f}, true);
  expect_near(uvs[0], {0, 0.5f});
  expect_near(uvs[2], {0.5f, 0.75f});
  const std::vector<vec2> high = read_uvs({3, 0.5f, 3.5f, 0.5f, 3.5f, 0.75f, 3, 0.75f}, true);
  expect_near(high[0], {0.5f, 0.5f});
  expect_near(high[2], {1, 0.75f});
}

TEST(Triangles, a_large_layout_keeps_its_aspect) {
  const std::vector<vec2> uvs = read_uvs({-7.6f, 2, 8.4f, 2, 8.4f, 6, -7.6f, 6}, true); // 16 by 4
  expect_near(uvs[2] - uvs[0], {1, 0.25f});
  const std::vector<vec2> tiles = read_uvs({0, 0, 3, 0, 3, 2, 0, 2}, true); // 3 by 2 UDIM tiles
  expect_near(tiles[2] - tiles[0], {1, 2.0f / 3.0f});
}

TEST(Triangles, layouts_of_any_size_and_place_end_within_the_unit_square) {
  for (const float size : {1e-3f, 0.7f, 1.1f, 3.3f, 7e7f, 1e30f})
    for (const float at : {-1e6f, -0.3f, 0.31f, 1e3f}) {
      const float end = at + size;
      read_uvs({at, at, end, at, end, end, at, end}, at < 0 || end > 1);
    }
}

TEST(Triangles, an_edge_is_sharp_from_both_sides_whatever_its_order) {
  Square square;
  square.sharp = {2, 0};
  const Triangles triangles = read_triangles(square.input());
  EXPECT_EQ(triangles.half_edge_sharp, (std::vector<uint8_t>{0, 0, 1, 1, 0, 0}));
}

TEST(Triangles, a_sharp_edge_of_a_flat_face_does_not_count_on_its_side) {
  Square square;
  square.sharp = {0, 2, 0, 1};
  square.smooth = {0, 1};
  const Triangles triangles = read_triangles(square.input());
  EXPECT_EQ(triangles.half_edge_sharp, (std::vector<uint8_t>{0, 0, 0, 1, 0, 0}));
}

} // namespace
} // namespace paradesc
