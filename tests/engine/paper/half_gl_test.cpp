// Buffers in 16-bit floats against those in 32 bits: 17 bits of normals, 16 of positions and 11 of area elements, whatever the
// scale of the UV map.
#include "engine/paper/geometry_buffer.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/paper/baked.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

constexpr float rounding = 1.0f / 2048; // half of a half's last place, of a number from 1 to 2

using HalfBuffers = OnDevice;

TEST_F(HalfBuffers, hold_positions_normals_and_ids_of_the_full_ones) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 800});
  lay_out(mesh, {.charts = 15});
  const Built built = build(mesh);
  const Buffers full = bake(*thread, built, 128), half = bake(*thread, built, 128, 1, true);
  EXPECT_EQ(full.ids, half.ids);
  for (size_t i = 0; i < full.position.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      ASSERT_NEAR(full.position[i][k], half.position[i][k], 1.6e-5f) << "2^-16";
      ASSERT_NEAR(full.normal[i][k], half.normal[i][k], 1.6e-5f)
          << "2^-18 on the octahedron, up to four times that on the sphere";
    }
}

// A quad of the grid in a hundred thousandth of the map has an area element of 400 000, and its neighbor one of 40: a half ends
// at 65504.
TEST_F(HalfBuffers, hold_area_elements_of_every_scale) {
  for (const double scale : {1.0, 1e-2, 1e-3}) {
    const Built built = build(grid(2, 1, [&](dvec2 position, int x, int) {
      const dvec2 within = position - dvec2(x, 0);
      return (dvec2(0.5 * x + 0.1, 0.1) + within * (x == 0 ? 0.3 : 0.03)) * scale + dvec2(0.25);
    }));
    const Buffers full = bake(*thread, built, 512, 1), half = bake(*thread, built, 512, 1, true);
    int seen = 0;
    float largest = 0.0f;
    for (size_t i = 0; i < full.position.size(); ++i) {
      if (full.ids[2 * i] < 0) continue;
      ASSERT_NEAR(half.position[i].w, full.position[i].w, rounding * full.position[i].w) << "at scale " << scale;
      largest = std::max(largest, full.position[i].w);
      ++seen;
    }
    EXPECT_GT(seen, 3);
    EXPECT_GT(largest, 500.0f / static_cast<float>(scale * scale));
  }
}

TEST_F(HalfBuffers, area_elements_beyond_the_largest_half_are_finite) {
  // The second quad has a millionth of the first one's area in (u, v), and so an area element a million times as large as the
  // mean.
  const Built built = build(grid(2, 1, [](dvec2 position, int x, int) {
    return x == 0 ? position * 0.5 : dvec2(0.75) + (position - dvec2(1, 0)) * 0.0005;
  }));
  const Buffers half = bake(*thread, built, 256, 1, true);
  int seen = 0;
  for (size_t i = 0; i < half.position.size(); ++i) {
    ASSERT_TRUE(std::isfinite(half.position[i].w));
    seen += half.ids[2 * i] == 1;
  }
  EXPECT_GT(seen, 0) << "the line around the small quad is drawn";
}

TEST_F(HalfBuffers, take_32_instead_of_48_bytes_a_texel) {
  thread->run([&](const Gl &gl, ProgramCache &) {
    EXPECT_DOUBLE_EQ(GeometryBuffer(gl, 100).megabytes(), 0.48);
    EXPECT_DOUBLE_EQ(GeometryBuffer(gl, 100, true).megabytes(), 0.32);
  });
}

} // namespace
} // namespace paradesc::test
