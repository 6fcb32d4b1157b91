// The baked buffers and the cells made from them, against the surface they stand for.
#include <gtest/gtest.h>

#include <cmath>
#include <queue>
#include <set>

#include "bake/gbuffer.h"
#include "gpu/gl_thread.h"
#include "mesh/normals.h"
#include "sample/cells.h"
#include "support/error.h"
#include "support/layout.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr int size = 512, block = 8;

// A mesh through the stages up to its cells.
struct Baked {
  Triangles triangles;
  HalfEdges half_edges;
  Charts charts;
  Normals normals;
  BufferFrame frame;
  std::vector<vec4> positions, normal_texels, distortion;
  std::vector<int32_t> ids;
  TexelCounts counts;
  Cells cells;

  Baked(GlThread &thread, const TestMesh &mesh)
      : triangles(read_triangles(input_of(mesh))), half_edges(build_half_edges(triangles)), charts(build_charts(triangles, half_edges)) {
    const NormalRings rings = build_normal_rings(triangles, half_edges);
    normals = compute_normals(triangles, half_edges, rings, PDESC_NORMALS_FITTED, 0);
    frame = frame_of(triangles, half_edges);
    const std::vector<vec4> forms = first_fundamental_forms(triangles, charts, frame, 0);
    const BakeVertices vertices = build_bake_vertices(triangles, charts, rings.corner_fan);
    thread.run([&](const Gl &gl, ProgramCache &programs) {
      GeometryBuffer buffer(gl, size);
      buffer.bake(programs, {triangles, charts, vertices, normals, forms, frame}, true);
      counts = buffer.count_owners(programs);
      positions = buffer.read_position();
      normal_texels = buffer.read_normal();
      distortion = buffer.read_distortion(programs);
      ids = buffer.read_ids();
    });
    cells = build_cells(ids, build_border_grid(triangles, charts, size), triangles, half_edges, charts, block);
  }

  double area() const {
    double sum = 0;
    for (size_t c = 0; c < triangles.corner_vertex.size(); c += 3) {
      const auto at = [&](size_t i) { return dvec3(triangles.positions[static_cast<size_t>(triangles.corner_vertex[c + i])]); };
      sum += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
    }
    return sum * frame.scale * frame.scale;
  }
};

class Surface : public ::testing::Test {
protected:
  void SetUp() override {
    try {
      thread = std::make_unique<GlThread>(true, -1);
    } catch (const Error &error) {
      GTEST_SKIP() << error.what();
    }
  }
  std::unique_ptr<GlThread> thread;
};

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
    const dvec3 p = dvec3(baked.positions[i]) / baked.frame.scale + baked.frame.center;
    const double tube = std::hypot(std::hypot(p.x, p.y) - 1, p.z);
    ASSERT_NEAR(tube, 0.4, depth);
    ASSERT_NEAR(glm::length(vec3(baked.normal_texels[i])), 1.0f, 1e-5f);
    ASSERT_GE(baked.distortion[i].x, baked.distortion[i].y);
    ASSERT_NEAR(baked.distortion[i].x * baked.distortion[i].y, baked.distortion[i].w, 1e-3f * baked.distortion[i].w);
  }
  EXPECT_GT(seen, size * size / 4);
  EXPECT_EQ(baked.counts.overlapping, 0);
}

// Each texel stands for its area element times the part of it that is on the chart. Partly covered texels round to sixteenths without
// bias; 0.2 % leaves room for the few that another chart owns.
TEST_F(Surface, areas_of_texels_make_up_the_surface) {
  for (const int charts : {1, 15, 60}) {
    const Baked baked(*thread, torus_of_charts(charts));
    double sum = 0;
    for (size_t i = 0; i < baked.positions.size(); ++i)
      if (baked.cells.label[2 * i] >= 0)
        sum += static_cast<double>(baked.positions[i].w) * baked.cells.label[2 * i + 1] / 65536.0 / (size * size);
    EXPECT_NEAR(sum / baked.area(), 1.0, 2e-3) << charts << " charts";
    EXPECT_TRUE(baked.cells.bare.empty()) << charts << " charts";
  }
}

TEST_F(Surface, cells_keep_to_one_chart_and_one_block) {
  const Baked baked(*thread, torus_of_charts(60));
  std::vector<int32_t> chart(static_cast<size_t>(baked.cells.count), -1);
  for (size_t i = 0; i < baked.positions.size(); ++i) {
    const int32_t cell = baked.cells.label[2 * i];
    const bool on_chart = baked.ids[2 * i] >= 0 && baked.ids[2 * i + 1] >= 0;
    ASSERT_TRUE(cell >= 0 || !on_chart) << "a texel on a chart belongs to no cell";
    if (cell < 0) continue;
    const auto c = static_cast<size_t>(cell);
    if (chart[c] < 0) chart[c] = baked.ids[2 * i];
    ASSERT_EQ(chart[c], baked.ids[2 * i]);
    ASSERT_EQ(static_cast<int>(i % size) / block * block, baked.cells.corner[2 * c]);
    ASSERT_EQ(static_cast<int>(i / size) / block * block, baked.cells.corner[2 * c + 1]);
  }
}

// All cells that links lead to.
std::set<int32_t> reached(const Cells &cells, int32_t start) {
  std::set<int32_t> seen{start};
  std::queue<int32_t> queue({start});
  while (!queue.empty()) {
    const auto cell = static_cast<size_t>(queue.front());
    queue.pop();
    for (int32_t k = cells.side_begin[cell]; k < cells.side_begin[cell + 1]; ++k)
      if (seen.insert(cells.side[static_cast<size_t>(k)].x).second) queue.push(cells.side[static_cast<size_t>(k)].x);
  }
  return seen;
}

TEST_F(Surface, links_lead_over_all_seams) {
  for (const int charts : {1, 15, 60}) {
    const Baked baked(*thread, torus_of_charts(charts));
    EXPECT_EQ(reached(baked.cells, 0).size(), static_cast<size_t>(baked.cells.count)) << charts << " charts";
  }
}

// Two strips of one chart, joined at one end, a third of a texel apart: the way from one to the other is round the end.
TEST_F(Surface, a_gap_narrower_than_a_texel_parts_cells) {
  TestMesh mesh;
  const float gap = 0.34f / size;
  const std::vector<vec3> points{{0.1f, 0.1f, 0}, {0.9f, 0.1f, 0}, {0.9f, 0.3f, 0}, {0.1f, 0.3f, 0},
                                 {0.1f, 0.5f + gap, 0}, {0.9f, 0.5f + gap, 0}, {0.1f, 0.3f + gap, 0}, {0.9f, 0.3f + gap, 0}, {0.05f, 0.3f, 0}};
  const int triangles[][3] = {{0, 1, 2}, {0, 2, 3}, {6, 7, 5}, {6, 5, 4}, {8, 0, 3}, {8, 6, 4}};
  mesh.vertex_count = static_cast<int32_t>(points.size());
  for (const vec3 p : points) mesh.positions.insert(mesh.positions.end(), {p.x, p.y, p.z});
  for (const auto &triangle : triangles)
    for (const int vertex : triangle) {
      mesh.triangle_corners.push_back(static_cast<int32_t>(mesh.corner_vertices.size()));
      mesh.corner_vertices.push_back(vertex);
      mesh.corner_uvs.insert(mesh.corner_uvs.end(), {points[static_cast<size_t>(vertex)].x, points[static_cast<size_t>(vertex)].y});
    }
  const Baked baked(*thread, mesh);
  const auto cell_at = [&](double x, double y) {
    return baked.cells.label[2 * (static_cast<size_t>(y * size) * size + static_cast<size_t>(x * size))];
  };
  const int32_t below = cell_at(0.5, 0.3 - 1.5 / size), above = cell_at(0.5, 0.3 + 2.0 / size);
  ASSERT_GE(below, 0);
  ASSERT_GE(above, 0);
  EXPECT_NE(below, above);
  EXPECT_EQ(reached(baked.cells, below).count(above), 0u) << "the strips share vertex 8 only, and a vertex joins nothing";
}

} // namespace
} // namespace paradesc::test
