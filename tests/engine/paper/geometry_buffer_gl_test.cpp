// Baked texels against the surface at their centers: exact on a plane, where everything is linear.
#include "engine/paper/geometry_buffer.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "engine/paper/baked.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

constexpr int size = 128;

// How far inside a triangle's UVs a position lies: the smallest barycentric coordinate times that side's distance in texels.
double depth_inside(const Built &built, int triangle, dvec2 position) {
  const dvec2 a = built.uv(3 * triangle), b = built.uv(3 * triangle + 1), c = built.uv(3 * triangle + 2);
  const double turn = paradesc::cross(b - a, c - a) > 0.0 ? size : -size;
  auto from = [&](dvec2 p, dvec2 q) { return turn * paradesc::cross(q - p, position - p) / length(q - p); };
  return std::min({from(a, b), from(b, c), from(c, a)});
}

// Rasterizers round corners to 1/256 of a texel; closer to an edge than two such steps either side may have a texel.
constexpr double snap = 2.0 / 256;

using GeometryBuffers = OnDevice;

TEST_F(GeometryBuffers, hold_the_surface_point_at_each_texels_center) {
  const Built built = plane_of_twelve_charts();
  const Buffers buffers = bake(*thread, built, size);
  int seen = 0;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      if (buffers.chart(x, y) < 0 || buffers.triangle(x, y) < 0) continue;
      const Affine chart = chart_of_quad(buffers.chart(x, y) % 4, buffers.chart(x, y) / 4);
      const dvec2 position = inverse(chart.linear) * (buffers.center(x, y) - chart.origin);
      const vec3 expected = buffers.bake_space.to_buffer(vec3(vec2(position), 0.0f));
      // A corner rounded by 1/512 of a texel moves the point by that much: texels are about 1/10 of a quad, which is half a unit.
      EXPECT_LT(length(vec3(buffers.position_at(x, y)) - expected), 0.05f / 256) << x << ", " << y;
      ++seen;
    }
  EXPECT_GT(seen, 1000);
}

TEST_F(GeometryBuffers, hold_it_to_float_precision_where_corners_lie_on_texels_corners) {
  const Built built = build(grid(6, 6, [](dvec2 position, int, int) { return (position + 1.0) / 8.0; }));
  const Buffers buffers = bake(*thread, built, size);
  for (int y = 16; y < 112; ++y)
    for (int x = 16; x < 112; ++x) {
      ASSERT_GE(buffers.triangle(x, y), 0);
      const vec3 expected = buffers.bake_space.to_buffer(vec3(vec2(buffers.center(x, y) * 8.0 - 1.0), 0.0f));
      EXPECT_LT(length(vec3(buffers.position_at(x, y)) - expected), 2e-6f) << "a few roundings of numbers up to 1";
    }
}

TEST_F(GeometryBuffers, hold_unit_normals_and_the_area_element_of_the_texels_triangle) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 800});
  lay_out(mesh, {.charts = 15});
  const Built built = build(mesh);
  const Buffers buffers = bake(*thread, built, size);
  for (size_t i = 0; i < buffers.position.size(); ++i) {
    if (buffers.ids[2 * i] < 0) {
      EXPECT_EQ(buffers.position[i].w, 0.0f) << "0: no surface";
      continue;
    }
    const int32_t id = buffers.ids[2 * i + 1], triangle = id < 0 ? -1 - id : id;
    EXPECT_NEAR(length(vec3(buffers.normal[i])), 1.0f, 1e-5f);
    EXPECT_NEAR(buffers.position[i].w / buffers.forms[at(triangle)].w, 1.0f, 1e-5f); // of edges of a tenth, in floats
    EXPECT_EQ(buffers.ids[2 * i], built.charts.triangle_chart[at(triangle)]);
  }
}

TEST_F(GeometryBuffers, every_texel_within_a_triangle_is_its_own_and_no_line_takes_it) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 800});
  lay_out(mesh, {.charts = 60}); // many chart edges, many of them next to other charts' texels
  const Built built = build(mesh);
  const Buffers buffers = bake(*thread, built, size);
  int seen = 0;
  for (int t = 0; t < built.triangles.triangle_count; ++t) {
    const dvec2 corners[] = {built.uv(3 * t), built.uv(3 * t + 1), built.uv(3 * t + 2)};
    const dvec2 low = glm::min(glm::min(corners[0], corners[1]), corners[2]) * static_cast<double>(size);
    const dvec2 high = glm::max(glm::max(corners[0], corners[1]), corners[2]) * static_cast<double>(size);
    for (int y = static_cast<int>(low.y); y <= static_cast<int>(high.y); ++y)
      for (int x = static_cast<int>(low.x); x <= static_cast<int>(high.x); ++x) {
        if (depth_inside(built, t, buffers.center(x, y)) < snap) continue;
        EXPECT_EQ(buffers.triangle(x, y), t) << x << ", " << y;
        ++seen;
      }
  }
  EXPECT_GT(seen, 3000);
}

TEST_F(GeometryBuffers, no_texel_within_a_chart_is_without_an_owner_and_none_off_it_claims_to_be_on_it) {
  const Built built = plane_of_twelve_charts();
  const Buffers buffers = bake(*thread, built, size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      for (int chart = 0; chart < 12; ++chart) {
        const Affine affine = chart_of_quad(chart % 4, chart / 4);
        const dvec2 position = inverse(affine.linear) * (buffers.center(x, y) - affine.origin) - dvec2(chart % 4, chart / 4);
        const double depth =
            std::min({position.x, position.y, 1 - position.x, 1 - position.y}) * 0.08 * size; // of a chart's smallest stretch
        if (depth > snap) {
          EXPECT_EQ(buffers.chart(x, y), chart);
          EXPECT_GE(buffers.triangle(x, y), 0);
        } else if (depth < -2 * snap && buffers.chart(x, y) == chart) {
          EXPECT_LT(buffers.triangle(x, y), 0) << "a line's";
        }
      }
}

TEST_F(GeometryBuffers, a_line_reaches_every_texel_that_a_chart_edge_passes_through) {
  const Built built = plane_of_twelve_charts();
  const Buffers buffers = bake(*thread, built, size);
  for (const Border &border : built.charts.borders) {
    const dvec2 a = built.uv(border.half_edge), b = built.uv(next_corner(border.half_edge));
    for (int k = 0; k <= 200; ++k) {
      const dvec2 position = (a + (b - a) * (k / 200.0)) * static_cast<double>(size);
      EXPECT_GE(buffers.chart(static_cast<int>(position.x), static_cast<int>(position.y)), 0);
    }
  }
}

TEST_F(GeometryBuffers, the_distortion_is_that_of_the_affine_map) {
  // Space to (u, v): turned by 30 degrees and stretched; so P stretches by 2 : 3 along these directions of (u, v), times one
  // scale.
  const double turn = pi / 6;
  const dmat2 rotation(std::cos(turn), std::sin(turn), -std::sin(turn), std::cos(turn));
  const dmat2 linear = rotation * dmat2(1.0 / 2, 0, 0, 1.0 / 3) * 0.2;
  const Built built = build(grid(4, 4, [&](dvec2 position, int, int) { return dvec2(0.4, 0.3) + linear * position; }));
  const Buffers buffers = bake(*thread, built, size);
  const double unit = buffers.bake_space.scale / 0.2;
  int seen = 0;
  for (size_t i = 0; i < buffers.distortion.size(); ++i) {
    const vec4 value = buffers.distortion[i];
    if (buffers.ids[2 * i] < 0) {
      EXPECT_EQ(value, vec4(0.0f));
      continue;
    }
    ++seen;
    // UVs are floats, edges a tenth of them: about ten roundings.
    EXPECT_GE(value.x, value.y);
    EXPECT_NEAR(value.x, 3 * unit, 1e-5 * 3 * unit);
    EXPECT_NEAR(value.y, 2 * unit, 1e-5 * 3 * unit);
    EXPECT_NEAR(value.w, 6 * unit * unit, 1e-5 * 6 * unit * unit);
    // The larger stretch lies across the turned u axis; an angle of a line is one modulo half a turn.
    EXPECT_NEAR(std::remainder(static_cast<double>(value.z) - (turn + pi / 2), pi), 0.0, 1e-4);
  }
  EXPECT_GT(seen, 500);
}

TEST_F(GeometryBuffers, texels_of_several_triangles_are_counted) {
  // Quads on texels' corners: 32 x 32 texels each, the second half over the first.
  const Built apart = build(grid(2, 1, [](dvec2 position, int, int) { return position * 0.25; }));
  const TexelCounts once = bake(*thread, apart, size).counts;
  EXPECT_EQ(once.covered, 2 * 32 * 32);
  EXPECT_EQ(once.overlapping, 0);
  const Built over = build(grid(2, 1, [](dvec2 position, int x, int) { return (position - dvec2(0.5 * x, 0)) * 0.25; }));
  const TexelCounts twice = bake(*thread, over, size).counts;
  EXPECT_EQ(twice.covered, 32 * 48);
  EXPECT_EQ(twice.overlapping, 32 * 16);
}

TEST_F(GeometryBuffers, covered_texels_are_those_that_a_triangle_owns) {
  const Buffers buffers = bake(*thread, plane_of_twelve_charts(), size);
  int owned = 0;
  for (size_t i = 0; i < buffers.ids.size(); i += 2) owned += buffers.ids[i] >= 0 && buffers.ids[i + 1] >= 0;
  EXPECT_EQ(buffers.counts.covered, owned);
  EXPECT_EQ(buffers.counts.overlapping, 0);
}

TEST_F(GeometryBuffers, two_bakes_have_the_same_bits) {
  const auto same = [](const auto &a, const auto &b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
  };
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 15});
  const Built built = build(mesh);
  const Buffers first = bake(*thread, built, size);
  for (const Buffers &again : {bake(*thread, built, size), bake(*thread, built, size, 2)}) { // a new buffer; the same one twice
    EXPECT_TRUE(same(first.position, again.position));
    EXPECT_TRUE(same(first.normal, again.normal));
    EXPECT_TRUE(same(first.ids, again.ids));
    EXPECT_TRUE(same(first.distortion, again.distortion));
  }
}

} // namespace
} // namespace paradesc::test
