// Texels that the device displaces against the CPU's formulas at the same positions.
#include "engine/paper/surface_mapper.h"

#include <algorithm>
#include <cmath>

#include "bake/mapped.h"
#include "engine/paper/baked.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

constexpr int size = 128;

// A position on a triangle's side, seen from a texel's center, in texels.
struct OnSide {
  dvec3 part; // barycentric coordinates
  double away;
  double beyond; // how far the center lies off the line that is drawn for the side; below 0: on it
};

// Nearest first; line: only on sides that are chart edges.
std::vector<OnSide> positions_on_sides(const Built &built, int triangle, bool line, const dvec2 (&corner)[3]) {
  constexpr double half_diagonal = 0.7072; // edge.vert.glsl
  std::vector<OnSide> found;
  for (int i = 0; i < 3; ++i) {
    if (line && built.charts.half_edge_border[at(3 * triangle + i)] < 0) continue;
    const dvec2 from = corner[i] * static_cast<double>(size), way = corner[(i + 1) % 3] * static_cast<double>(size) - from;
    const double along = -dot(from, way) / dot(way, way), t = std::clamp(along, 0.0, 1.0), span = glm::length(way);
    const double across = std::abs(paradesc::cross(from, way)) / span;
    OnSide on_side{dvec3(0.0), glm::length(from + way * t),
                   std::max({across, -along * span, (along - 1) * span}) - half_diagonal};
    on_side.part[i] = 1 - t;
    on_side.part[(i + 1) % 3] = t;
    found.push_back(on_side);
  }
  std::sort(found.begin(), found.end(), [](const OnSide &a, const OnSide &b) { return a.away < b.away; });
  return found;
}

// Barycentric coordinates of the position that a texel stands for: the one of the triangle nearest to its center, or the one on
// the lines drawn for the chart's edges; several where rounding decides which lines have the center.
std::vector<dvec3> positions_of(const Built &built, int triangle, bool line, dvec2 center) {
  constexpr double rounding = 2.0 / 256;
  const dvec2 corner[3] = {built.uv(3 * triangle) - center, built.uv(3 * triangle + 1) - center,
                           built.uv(3 * triangle + 2) - center};
  const dvec3 inside(paradesc::cross(corner[1], corner[2]), paradesc::cross(corner[2], corner[0]),
                     paradesc::cross(corner[0], corner[1]));
  const dvec3 part = inside / (inside.x + inside.y + inside.z);
  if (!line && std::min({part.x, part.y, part.z}) >= 0.0) return {part};
  std::vector<dvec3> found;
  for (const OnSide &on_side : positions_on_sides(built, triangle, line, corner)) {
    if (on_side.beyond < rounding) found.push_back(on_side.part);
    if (on_side.beyond < -rounding) break;
  }
  return found;
}

class DisplacedTexels : public OnDevice {
protected:
  void SetUp() override {
    OnDevice::SetUp();
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
    buffers.bake_space = bake_space_of(bounding_box(built.triangles, built.half_edges));
    const NormalRings rings = build_normal_rings(built.triangles, built.half_edges);
    buffers.normals = compute_normals(built.triangles, built.half_edges, rings, PDESC_NORMALS_FITTED, 0);
    thread->run([&](const Gl &gl, ProgramCache &programs) {
      GeometryBuffer buffer(gl, size);
      SurfaceMapper mapper;
      const BakeInput input{built.triangles, built.charts, buffers.bake_space};
      draw_layout(buffer, programs, input);
      draw_frame(buffer, programs, input, buffers.normals);
      mapper.run(gl, programs, buffer, input, buffers.normals, maps);
      buffers.position = buffer.read_position();
      buffers.normal = buffer.read_normal();
      buffers.ids = buffer.read_ids();
    });
    buffers.size = size;
    compare(buffers);
  }

  void compare(const Buffers &buffers) const {
    const DisplacedSurface surface(maps, built.triangles, buffers.normals, buffers.bake_space);
    int triangles = 0, lines = 0;
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        if (buffers.chart(x, y) < 0) continue;
        const int32_t id = buffers.triangle(x, y), triangle = id < 0 ? -1 - id : id;
        const vec4 found = buffers.position_at(x, y);
        SurfacePoint expected{vec3(1e9f), {}, 0.0f};
        for (const dvec3 part : positions_of(built, triangle, id < 0, buffers.center(x, y))) {
          const SurfacePoint point = surface.at(triangle, static_cast<float>(part.y), static_cast<float>(part.z));
          if (glm::length(vec3(found) - point.position) < glm::length(vec3(found) - expected.position)) expected = point;
        }
        // A (u, v) is known to 1e-7; a slope divides by a pixel of 1/64.
        ASSERT_LT(glm::length(vec3(found) - expected.position), 2e-5f) << x << ", " << y;
        ASSERT_LT(glm::length(vec3(buffers.normal[at(y * size + x)]) - expected.normal), 2e-4f) << x << ", " << y;
        ASSERT_NEAR(found.w / (form_of(built.triangles, built.charts, buffers.bake_space, at(triangle)).w * expected.area_ratio),
                    1.0f, 2e-4f)
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

TEST_F(DisplacedTexels, are_displaced_as_the_cpu_computes) {
  displace();
  expect_the_cpus();
}

TEST_F(DisplacedTexels, have_the_normals_that_the_cpu_computes) {
  map_normals();
  expect_the_cpus();
}

TEST_F(DisplacedTexels, are_displaced_and_have_the_maps_normals) {
  displace();
  map_normals();
  expect_the_cpus();
}

TEST(DisplacedPoints, a_displacement_whose_squares_no_float_holds_enlarges_no_ellipse) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 100});
  lay_out(mesh, {.charts = 4});
  const Built built = build(mesh);
  const BakeSpace bake_space = bake_space_of(bounding_box(built.triangles, built.half_edges));
  const NormalRings rings = build_normal_rings(built.triangles, built.half_edges);
  const Normals normals = compute_normals(built.triangles, built.half_edges, rings, PDESC_NORMALS_FITTED, 0);
  const float heights[] = {0, 1, 1, 0};
  SurfaceMaps maps;
  set_displacement(maps, built.triangles, heights, 2, 2, 0, 1e30);
  const float shrinkage = displace_points(maps, built.triangles, built.half_edges, normals, bake_space, 1).shrinkage;
  EXPECT_GE(shrinkage, 1.0f);
  EXPECT_LE(shrinkage, 4.0f); // else there are no samples, or any number of them
}

} // namespace
} // namespace paradesc::test
