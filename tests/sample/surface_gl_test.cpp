// The baked buffers against the surface they stand for.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "engine/paper/baked.h"
#include "mesh/normals.h"
#include "support/layout.h"
#include "support/on_device.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr int size = 512;

// A mesh through the stages up to its buffers.
struct Baked {
  Triangles triangles;
  HalfEdges half_edges;
  Charts charts;
  Normals normals;
  BakeSpace bake_space;
  std::vector<vec4> positions, normal_texels, distortion;
  std::vector<int32_t> ids;
  TexelCounts counts;

  Baked(GlThread &thread, const TestMesh &mesh)
      : triangles(read_triangles(input_of(mesh))), half_edges(build_half_edges(triangles)),
        charts(build_charts(triangles, half_edges)) {
    const NormalRings rings = build_normal_rings(triangles, half_edges);
    normals = compute_normals(triangles, half_edges, rings, PDESC_NORMALS_FITTED, 0);
    bake_space = bake_space_of(bounding_box(triangles, half_edges));
    thread.run([&](const Gl &gl, ProgramCache &programs) {
      GeometryBuffer buffer(gl, size);
      const BakeInput input{triangles, charts, bake_space};
      counts = draw_layout(buffer, programs, input);
      draw_frame(buffer, programs, input, normals);
      positions = buffer.read_position();
      normal_texels = buffer.read_normal();
      distortion = buffer.read_distortion(programs);
      ids = buffer.read_ids();
    });
  }
};

using Surface = OnDevice;

TestMesh torus_of_charts(int charts) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 4000});
  lay_out(mesh, {.charts = charts});
  return mesh;
}

// The middle of a triangle with the longest edge L lies at most (L/sqrt 3)²/(2 R) below a tube of radius R.
TEST_F(Surface, texels_are_points_of_the_torus_with_unit_normals) {
  const TestMesh mesh = torus_of_charts(15);
  const Baked baked(*thread, mesh);
  const double depth = std::pow(longest_edge(mesh), 2) / 3 / (2 * 0.4);
  int seen = 0;
  for (size_t i = 0; i < baked.positions.size(); ++i) {
    if (baked.ids[2 * i] < 0) continue;
    ++seen;
    const dvec3 p = dvec3(baked.positions[i]) / baked.bake_space.scale + baked.bake_space.center;
    const double tube = std::hypot(std::hypot(p.x, p.y) - 1, p.z);
    ASSERT_NEAR(tube, 0.4, depth);
    ASSERT_NEAR(glm::length(vec3(baked.normal_texels[i])), 1.0f, 1e-5f);
    ASSERT_GE(baked.distortion[i].x, baked.distortion[i].y);
    ASSERT_NEAR(baked.distortion[i].x * baked.distortion[i].y, baked.distortion[i].w, 1e-3f * baked.distortion[i].w);
  }
  EXPECT_GT(seen, size * size / 4);
  EXPECT_EQ(baked.counts.overlapping, 0);
}

} // namespace
} // namespace paradesc::test
