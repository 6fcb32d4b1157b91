// Maps in texture space: every texel has the map's value at the surface point that it holds.
#include "engine/paper/geometry_buffer.h"

#include "engine/paper/baked.h"
#include "support/layout.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

using MapBuffers = OnDevice;

// A map of the positions themselves has to give the geometry buffer's positions back, at chart edges too.
TEST_F(MapBuffers, hold_the_map_at_the_point_of_each_texel) {
  TestMesh mesh = ellipsoid(1, 0.75, 0.5, {.vertices = 1500});
  lay_out(mesh, {.charts = 15, .warp = 0.3});
  const Built built = build(read_triangles(input_of(mesh)));
  Buffers buffers;
  buffers.bake_space = bake_space_of(bounding_box(built.triangles, built.half_edges));
  const NormalRings rings = build_normal_rings(built.triangles, built.half_edges);
  const Normals normals = compute_normals(built.triangles, built.half_edges, rings, PDESC_NORMALS_FITTED, 0);
  MapValues values;
  for (const int32_t vertex : built.half_edges.point_vertex)
    values.emplace_back(buffers.bake_space.to_buffer(built.triangles.positions[static_cast<size_t>(vertex)]), 7.0f);
  std::vector<vec4> map;
  thread->run([&](const Gl &gl, ProgramCache &programs) {
    GeometryBuffer buffer(gl, 256);
    const BakeInput input{built.triangles, built.charts, buffers.bake_space};
    draw_layout(buffer, programs, input);
    draw_frame(buffer, programs, input, normals);
    buffer.draw_map(programs, built.half_edges, values);
    map = buffer.read_map();
    buffers.position = buffer.read_position();
    buffers.ids = buffer.read_ids();
  });
  int edges = 0, inside = 0;
  for (size_t i = 0; i < map.size(); ++i) {
    if (buffers.ids[2 * i] < 0) {
      ASSERT_EQ(map[i], vec4(0.0f)) << "texel " << i << " lies on no chart";
      continue;
    }
    ++(buffers.ids[2 * i + 1] < 0 ? edges : inside);
    ASSERT_LE(length(vec3(map[i]) - vec3(buffers.position[i])), 1e-5f) << "texel " << i; // rounding of the interpolation
    ASSERT_NEAR(map[i].w, 7.0f, 1e-5f) << "texel " << i;
  }
  EXPECT_GT(edges, 1000);
  EXPECT_GT(inside, 10000);
}

} // namespace
} // namespace paradesc::test
