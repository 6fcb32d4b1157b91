// Texels that the device displaces against the CPU's formulas at the same places.
#include "bake/surface_maps.h"

#include <algorithm>
#include <cmath>

#include "bake/mapped.h"
#include "bake/stages.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

constexpr int size = 128;

// Barycentric coordinates of the triangle's place nearest to a texel's center; of a line's texel the nearest on the chart's edge,
// or on two of its edges that are as near in the floats of a depth buffer.
std::vector<dvec3> nearest_places(const Built &built, int triangle, bool line, dvec2 center) {
  const dvec2 corner[3] = {built.uv(3 * triangle) - center, built.uv(3 * triangle + 1) - center,
                           built.uv(3 * triangle + 2) - center};
  const double area = paradesc::cross(corner[1] - corner[0], corner[2] - corner[0]);
  const dvec3 inside(paradesc::cross(corner[1], corner[2]), paradesc::cross(corner[2], corner[0]),
                     paradesc::cross(corner[0], corner[1]));
  if (!line && std::min({inside.x / area, inside.y / area, inside.z / area}) >= 0) return {inside / area};
  std::vector<std::pair<double, dvec3>> places;
  for (int i = 0; i < 3; ++i) {
    if (line && built.charts.half_edge_border[at(3 * triangle + i)] < 0) continue;
    const dvec2 from = corner[i], way = corner[(i + 1) % 3] - from;
    const double t = std::clamp(-dot(from, way) / dot(way, way), 0.0, 1.0);
    dvec3 part(0.0);
    part[i] = 1 - t;
    part[(i + 1) % 3] = t;
    places.emplace_back(glm::length(from + way * t), part);
  }
  std::sort(places.begin(), places.end(), [](const auto &a, const auto &b) { return a.first < b.first; });
  std::vector<dvec3> nearest;
  for (const auto &[away, part] : places)
    if (nearest.empty() || (line && away - places[0].first < 1e-6)) nearest.push_back(part);
  return nearest;
}

class MappedTexels : public OnSoftwareDevice {
protected:
  void SetUp() override {
    OnSoftwareDevice::SetUp();
    mesh = torus(1, 0.4, {.vertices = 500});
    lay_out(mesh, {.charts = 15});
    built = build(mesh);
  }

  void displace() {
    const Maps map = displacement(
        64, 32, [](double u, double v) { return std::sin(9 * u) * std::cos(7 * v + u); }, 0.3, 0.05);
    set_displacement(maps, built.triangles, map.heights.data(), 64, 32, map.midlevel, map.scale);
  }

  // Colors and tangents of no meaning, no two alike.
  void map_normals() {
    std::vector<float> rgb, tangents;
    for (int i = 0; i < 3 * 16 * 16; ++i) rgb.push_back(i % 3 == 2 ? 0.9f : 0.3f + 0.025f * static_cast<float>(i % 17));
    for (size_t i = 0; i < mesh.corner_vertices.size(); ++i)
      for (const float value : {0.6f, 0.01f * static_cast<float>(i % 31), -0.7f, i / 3 % 2 ? 1.0f : -1.0f})
        tangents.push_back(value);
    const auto corners = static_cast<int32_t>(mesh.corner_vertices.size());
    set_normal_map(maps, built.triangles, rgb.data(), 16, 16, tangents.data(), corners);
  }

  void expect_the_cpus() {
    Buffers buffers;
    buffers.frame = frame_of(built.triangles, built.half_edges);
    const NormalRings rings = build_normal_rings(built.triangles, built.half_edges);
    buffers.normals = compute_normals(built.triangles, built.half_edges, rings, PDESC_NORMALS_FITTED, 0);
    const BakeVertices vertices = build_bake_vertices(built.triangles, built.charts, *rings.corner_fan);
    thread->run([&](const Gl &gl, ProgramCache &programs) {
      GeometryBuffer buffer(gl, size);
      SurfaceMapper mapper;
      const BakeInput input{built.triangles, built.charts, vertices, buffers.normals, buffers.frame};
      draw_layout(buffer, programs, input);
      draw_frame(buffer, programs, input);
      mapper.run(gl, programs, buffer, input, maps);
      buffers.position = buffer.read_position();
      buffers.normal = buffer.read_normal();
      buffers.ids = buffer.read_ids();
    });
    buffers.size = size;
    compare(buffers);
  }

  void compare(const Buffers &buffers) const {
    const MappedSurface surface(maps, built.triangles, buffers.normals, buffers.frame);
    int triangles = 0, lines = 0;
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        if (buffers.chart(x, y) < 0) continue;
        const int32_t id = buffers.triangle(x, y), triangle = id < 0 ? -1 - id : id;
        const vec4 found = buffers.position_at(x, y);
        SurfacePoint expected{vec3(1e9f), {}, 0.0f};
        for (const dvec3 part : nearest_places(built, triangle, id < 0, buffers.center(x, y))) {
          const SurfacePoint point = surface.at(triangle, static_cast<float>(part.y), static_cast<float>(part.z));
          if (glm::length(vec3(found) - point.position) < glm::length(vec3(found) - expected.position)) expected = point;
        }
        // A place in (u, v) is known to 1e-7; a slope divides by a pixel of 1/64.
        ASSERT_LT(glm::length(vec3(found) - expected.position), 2e-5f) << x << ", " << y;
        ASSERT_LT(glm::length(vec3(buffers.normal[at(y * size + x)]) - expected.normal), 2e-4f) << x << ", " << y;
        ASSERT_NEAR(found.w / (form_of(built.triangles, buffers.frame, at(triangle)).w * expected.area_ratio), 1.0f, 2e-4f)
            << x << ", " << y;
        (id < 0 ? lines : triangles) += 1;
      }
    EXPECT_GT(triangles, 3000);
    EXPECT_GT(lines, 500);
  }

  TestMesh mesh;
  Built built;
  SurfaceMaps maps;
};

TEST_F(MappedTexels, are_displaced_as_the_cpu_computes) {
  displace();
  expect_the_cpus();
}

TEST_F(MappedTexels, have_the_normals_that_the_cpu_computes) {
  map_normals();
  expect_the_cpus();
}

TEST_F(MappedTexels, are_displaced_and_have_the_maps_normals) {
  displace();
  map_normals();
  expect_the_cpus();
}

} // namespace
} // namespace paradesc::test
