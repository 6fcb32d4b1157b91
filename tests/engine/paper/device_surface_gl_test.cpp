// Compares the places that the device makes of a mesh with those that the processor makes of it.
#include "engine/paper/device_surface.h"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "mesh/halfedge.h"
#include "support/on_device.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

using DeviceSurfaces = OnDevice;

// A place for each fan: its own vertex, its own normal.
TEST_F(DeviceSurfaces, put_places_where_the_mesh_is) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 300});
  for (float &coordinate : mesh.positions) coordinate = 1000.0f + 3.0f * coordinate;
  const Triangles triangles = read_triangles(input_of(mesh));
  const HalfEdges half_edges = build_half_edges(triangles);
  const NormalRings rings = build_normal_rings(triangles, half_edges);
  const Normals normals = compute_normals(triangles, half_edges, rings, PDESC_NORMALS_FITTED, 0);
  const BakeSpace space = bake_space_of(bounding_box(triangles, half_edges));
  std::vector<ivec2> sources;
  for (int32_t fan = 0; fan < rings.fan_count; ++fan)
    sources.emplace_back(half_edges.point_vertex[static_cast<size_t>(rings.fan_point[static_cast<size_t>(fan)])], fan);
  std::vector<vec4> places(2 * sources.size(), vec4(std::numeric_limits<float>::quiet_NaN()));
  thread->run([&](const Gl &gl, ProgramCache &programs) {
    DeviceSurface surface;
    surface.set_positions(gl, triangles, space, 0);
    surface.set_normals(gl, normals);
    Buffer buffer;
    buffer.upload(gl, places);
    surface.place(gl, programs, Places(gl, sources), buffer.id());
    gl.MemoryBarrier(GL_ALL_BARRIER_BITS);
    gl.GetNamedBufferSubData(buffer.id(), 0, static_cast<GLsizeiptr>(places.size() * sizeof(vec4)), places.data());
    check_gl(gl, "read-back");
  });
  for (size_t fan = 0; fan < sources.size(); ++fan) {
    EXPECT_EQ(vec3(places[2 * fan]), space.to_buffer(triangles.positions[static_cast<size_t>(sources[fan].x)])) << fan;
    EXPECT_EQ(vec3(places[2 * fan + 1]), normals.group[fan]) << fan;
  }
}

} // namespace
} // namespace paradesc::test
