// What the device makes of a mesh against what the processor makes of it: normals, faces and places.
#include "engine/opengl/device_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "compute/compute.h"
#include "context.h"
#include "descriptor/registry.h"
#include "engine/opengl/faults.h"
#include "mesh/halfedge.h"
#include "support/layout.h"
#include "support/on_device.h"
#include "support/run.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

class DeviceSurfaces : public OnDevice {
protected:
  // A place for each fan: its own vertex, its own normal. (fans, 2) position, normal.
  std::vector<vec4> places_of(Triangles list, int32_t kind, bool made_by_processor = false) {
    triangles = std::move(list);
    half_edges = build_half_edges(triangles);
    rings = build_normal_rings(triangles, half_edges);
    expected = compute_normals(triangles, half_edges, rings, kind, 0);
    space = bake_space_of(bounding_box(triangles, half_edges));
    std::vector<ivec2> sources;
    for (int32_t fan = 0; fan < rings.fan_count; ++fan)
      sources.emplace_back(rings.fan_vertex[static_cast<size_t>(rings.fan_begin[static_cast<size_t>(fan)])], fan);
    std::vector<vec4> places(2 * sources.size(), vec4(std::numeric_limits<float>::quiet_NaN()));
    thread->run([&](const Gl &gl, ProgramCache &programs) {
      DeviceSurface surface;
      surface.set_positions(gl, triangles, space, 0);
      if (made_by_processor) {
        surface.set_normals(gl, expected);
      } else {
        surface.begin_normals(gl, rings, 1);
        for (int first = 0; first < surface.fan_count(); first += 1000)
          surface.fit_normals(gl, programs, kind == PDESC_NORMALS_FITTED, first, std::min(first + 1000, surface.fan_count()));
      }
      Buffer buffer;
      buffer.upload(gl, places);
      surface.place(gl, programs, Places(gl, sources), buffer.id(), 8);
      gl.MemoryBarrier(GL_ALL_BARRIER_BITS);
      gl.GetNamedBufferSubData(buffer.id(), 0, static_cast<GLsizeiptr>(places.size() * sizeof(vec4)), places.data());
      check_gl(gl, "read-back");
    });
    return places;
  }

  // Both are in doubles and round once; sums may be put together in another way.
  void expect_the_processors(const TestMesh &mesh, int32_t kind) { expect_the_processors(read_triangles(input_of(mesh)), kind); }
  void expect_the_processors(Triangles list, int32_t kind) {
    const std::vector<vec4> places = places_of(std::move(list), kind);
    ASSERT_GT(rings.fan_count, 0);
    for (size_t fan = 0; fan < static_cast<size_t>(rings.fan_count); ++fan)
      ASSERT_LT(length(vec3(places[2 * fan + 1]) - expected.group[fan]), 2e-7f) << "fan " << fan << " of " << rings.fan_count;
  }

  Triangles triangles;
  HalfEdges half_edges;
  NormalRings rings;
  Normals expected;
  BakeSpace space;
};

TEST_F(DeviceSurfaces, have_the_normals_that_the_processor_fits) {
  for (const int32_t kind : {PDESC_NORMALS_FITTED, PDESC_NORMALS_MAX}) {
    expect_the_processors(torus(1.0, 0.4, {.vertices = 3000}), kind);
    expect_the_processors(ellipsoid(1, 0.6, 0.3, {.vertices = 2000}), kind);
    expect_the_processors(saddle(1, {.vertices = 500}), kind); // with a boundary
  }
}

// Spread faces give way to Max's normal, small fans to a quadratic jet or to none.
TEST_F(DeviceSurfaces, have_them_on_hard_and_coarse_surfaces) {
  for (const int32_t kind : {PDESC_NORMALS_FITTED, PDESC_NORMALS_MAX}) {
    expect_the_processors(ellipsoid(1, 1, 1, {.vertices = 12}), kind);
    expect_the_processors(ellipsoid(1, 1, 0.02, {.vertices = 400}), kind);
    expect_the_processors(saddle(1, {.vertices = 9}), kind);
  }
}

// Faces that cancel out, one without area, and a fan of thousands of faces, of whose rings only some are taken.
TEST_F(DeviceSurfaces, have_them_on_shapes_that_are_no_surface) {
  for (const int32_t kind : {PDESC_NORMALS_FITTED, PDESC_NORMALS_MAX}) {
    expect_the_processors(shape({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2, 0, 2, 1}), kind);
    expect_the_processors(shape({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {0, 1, 3, 1, 2, 3, 0, 2, 1}), kind);
    expect_the_processors(cone(5000), kind);
  }
}

TEST_F(DeviceSurfaces, put_places_where_the_mesh_is_and_leave_what_lies_beside_them) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 300});
  for (float &coordinate : mesh.positions) coordinate = 1000.0f + 3.0f * coordinate;
  const std::vector<vec4> places = places_of(read_triangles(input_of(mesh)), PDESC_NORMALS_FITTED, true);
  for (size_t fan = 0; fan < static_cast<size_t>(rings.fan_count); ++fan) {
    const auto vertex = static_cast<size_t>(half_edges.point_vertex[static_cast<size_t>(rings.fan_point[fan])]);
    EXPECT_EQ(vec3(places[2 * fan]), space.to_buffer(triangles.positions[vertex])) << fan;
    EXPECT_EQ(vec3(places[2 * fan + 1]), expected.group[fan]) << fan;
    EXPECT_TRUE(std::isnan(places[2 * fan].w) && std::isnan(places[2 * fan + 1].w)) << fan;
  }
}

TEST_F(DeviceSurfaces, leave_normals_to_the_processor_where_rings_are_longer_than_a_device_lists) {
  TestMesh mesh = sphere(1, {.vertices = 3000}); // whose rings have 71,690 faces
  lay_out(mesh, {.charts = 6});
  const auto values_on = [&](const DriverSubstitute &driver) {
    const auto native = paradesc::make_mesh(open_device(driver), input_of(mesh));
    const int row = find_descriptor("mean_curvature");
    return compute(*native, options_of({.radius = 0.1, .samples = 16, .buffer_size = 64}), std::span(&row, 1),
                   [](const char *, double) { return true; })
        .values[0];
  };
  constexpr GLint shortest = 65536; // that OpenGL 4.5 allows
  const std::vector<float> fitted = values_on({}), found = values_on(with_short_lists(shortest));
  for (size_t i = 0; i < fitted.size(); ++i) ASSERT_NEAR(found[i], fitted[i], 1e-4f) << i; // normals differ by 2e-7
}

} // namespace
} // namespace paradesc::test
