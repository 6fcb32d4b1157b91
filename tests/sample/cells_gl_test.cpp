// Cells and their links on surfaces whose connections are known; areas of texels are in surface_gl_test.cpp.
#include "sample/cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <set>

#include <gtest/gtest.h>

#include "engine/opengl/baked.h"
#include "sample/texelless.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

constexpr int size = 256, block = 16;

TestMesh torus_of_charts(int charts) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = charts});
  return mesh;
}

std::vector<uint8_t> flood(const Cells &cells, int32_t start) {
  std::vector<uint8_t> reached(at(cells.count), 0);
  reached[at(start)] = 1;
  std::queue<int32_t> queue({start});
  while (!queue.empty()) {
    const int32_t cell = queue.front();
    queue.pop();
    for (int32_t k = cells.adjacency_begin[at(cell)]; k < cells.adjacency_begin[at(cell) + 1]; ++k) {
      const int32_t other = cells.adjacency[at(k)].x;
      if (!reached[at(other)]) queue.push(other);
      reached[at(other)] = 1;
    }
  }
  return reached;
}

// The chart of each cell.
std::vector<int32_t> charts_of(const Cells &cells, const Buffers &buffers) {
  std::vector<int32_t> chart(at(cells.count), -1);
  for (size_t i = 0; i < buffers.ids.size(); i += 2)
    if (cells.label[i] >= 0) chart[at(cells.label[i])] = buffers.ids[i];
  return chart;
}

using CellsOfTexels = OnDevice;

TexellessSamples texelless_samples(const Cells &cells, const Built &built, const Buffers &buffers, float radius) {
  return sample_texelless_triangles(
      cells, built.triangles, [&](size_t corner) { return buffers.normals.corner(corner); }, buffers.bake_space, radius);
}

TEST_F(CellsOfTexels, every_texel_of_a_triangle_has_a_cell_within_its_chart_and_block) {
  for (const int charts : {1, 15, 60}) {
    const Built built = build(torus_of_charts(charts));
    const Buffers buffers = bake(*thread, built, size);
    const Cells cells = cells_of(built, buffers, block);
    const std::vector<int32_t> chart = charts_of(cells, buffers);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const int32_t cell = cells.label[2 * at(y * size + x)], part = cells.label[2 * at(y * size + x) + 1];
        if (buffers.triangle(x, y) >= 0 && buffers.chart(x, y) >= 0) {
          ASSERT_GE(cell, 0) << x << ", " << y;
        }
        if (cell < 0) continue;
        EXPECT_EQ(buffers.chart(x, y), chart[at(cell)]);
        const ivec4 box = cells.box[at(cell)];
        EXPECT_TRUE(x >= box.x && x < box.x + box.z && y >= box.y && y < box.y + box.w) << x << ", " << y;
        EXPECT_TRUE(box.x / block == (box.x + box.z - 1) / block && box.y / block == (box.y + box.w - 1) / block);
        EXPECT_GE(part, 0);
        EXPECT_LE(part, 65536);
      }
  }
}

TEST_F(CellsOfTexels, links_are_the_same_from_both_of_their_cells) {
  const Built built = build(torus_of_charts(15));
  const Buffers buffers = bake(*thread, built, size);
  const Cells cells = cells_of(built, buffers, block);
  ASSERT_EQ(cells.adjacency.size(), 2 * (cells.link_begin.size() - 1));
  std::set<std::array<int32_t, 3>> adjacent;
  for (int32_t cell = 0; cell < cells.count; ++cell)
    for (int32_t k = cells.adjacency_begin[at(cell)]; k < cells.adjacency_begin[at(cell) + 1]; ++k)
      adjacent.insert({cell, cells.adjacency[at(k)].x, cells.adjacency[at(k)].y});
  EXPECT_EQ(adjacent.size(), cells.adjacency.size());
  for (const auto &[cell, other, link] : adjacent) {
    EXPECT_NE(cell, other);
    EXPECT_TRUE(adjacent.contains({other, cell, link}));
    EXPECT_LT(cells.link_begin[at(link)], cells.link_begin[at(link) + 1]) << "a link goes over somewhere";
  }
}

TEST_F(CellsOfTexels, links_go_over_at_texels_that_have_surface) {
  const Built built = build(torus_of_charts(15));
  const Buffers buffers = bake(*thread, built, size);
  for (const int32_t texel : cells_of(built, buffers, block).link_texel) EXPECT_GE(buffers.ids[2 * at(texel) + 1], 0);
}

TEST_F(CellsOfTexels, every_two_charts_with_a_common_seam_are_linked_and_no_others) {
  const Built built = build(torus_of_charts(15)); // every third chart mirrored
  const Buffers buffers = bake(*thread, built, size);
  const Cells cells = cells_of(built, buffers, block);
  const std::vector<int32_t> chart = charts_of(cells, buffers);
  std::set<std::pair<int32_t, int32_t>> seams, linked;
  for (const Border &border : built.charts.borders)
    if (border.kind == BorderKind::seam) seams.insert({border.chart, built.charts.borders[at(border.twin)].chart});
  for (int32_t cell = 0; cell < cells.count; ++cell)
    for (int32_t k = cells.adjacency_begin[at(cell)]; k < cells.adjacency_begin[at(cell) + 1]; ++k)
      if (chart[at(cell)] != chart[at(cells.adjacency[at(k)].x)])
        linked.insert({chart[at(cell)], chart[at(cells.adjacency[at(k)].x)]});
  EXPECT_EQ(linked, seams);
}

TEST_F(CellsOfTexels, all_wedges_of_a_point_are_joined_around_it) {
  // The cells of two wedges of one point are not only linked somehow: they are the same, linked directly, or have a common
  // neighbor.
  const Built built = build(torus_of_charts(15));
  const Buffers buffers = bake(*thread, built, size);
  const Cells cells = cells_of(built, buffers, block);
  const auto around = [&](int32_t cell) {
    std::set<int32_t> result{cell};
    for (int32_t k = cells.adjacency_begin[at(cell)]; k < cells.adjacency_begin[at(cell) + 1]; ++k)
      result.insert(cells.adjacency[at(k)].x);
    return result;
  };
  std::vector<int32_t> first(at(built.half_edges.point_count), -1);
  for (size_t i = 0; i < built.charts.wedges.size(); ++i) {
    ASSERT_GE(cells.wedge_cell[i], 0);
    int32_t &known = first[at(built.charts.wedges[i].point)];
    if (known < 0) known = cells.wedge_cell[i];
    const std::set<int32_t> a = around(known), b = around(cells.wedge_cell[i]);
    EXPECT_TRUE(std::ranges::any_of(a, [&](int32_t cell) { return b.contains(cell); })) << "wedge " << i;
  }
}

TEST_F(CellsOfTexels, links_lead_from_one_cell_to_all_of_a_connected_mesh) {
  for (const int charts : {1, 15, 60}) {
    const Built built = build(torus_of_charts(charts));
    const Cells cells = cells_of(built, bake(*thread, built, size), block);
    const std::vector<uint8_t> reached = flood(cells, 0);
    EXPECT_EQ(std::ranges::count(reached, 1), cells.count) << charts << " charts";
    EXPECT_TRUE(cells.boundary.empty());
  }
}

TEST_F(CellsOfTexels, links_stay_on_their_part_of_the_mesh) {
  // Two tori, the second beside the first in space and in the UV map.
  TestMesh mesh = torus_of_charts(15);
  const auto vertices = static_cast<int32_t>(mesh.positions.size() / 3);
  const size_t corners = mesh.corner_vertices.size();
  for (float &value : mesh.corner_uvs) value *= 0.5f;
  for (size_t i = 0; i < at(3 * vertices); ++i) mesh.positions.push_back(mesh.positions[i] + (i % 3 == 0 ? 3.0f : 0.0f));
  for (size_t i = 0; i < corners; ++i) {
    mesh.corner_vertices.push_back(mesh.corner_vertices[i] + vertices);
    mesh.triangle_corners.push_back(mesh.triangle_corners[i] + static_cast<int32_t>(corners));
    mesh.corner_uvs.push_back(mesh.corner_uvs[2 * i] + 0.5f);
    mesh.corner_uvs.push_back(mesh.corner_uvs[2 * i + 1] + 0.5f);
  }
  mesh.corner_normals.clear();
  mesh.vertex_count *= 2;
  const Built built = build(mesh);
  ASSERT_EQ(built.half_edges.components, 2);
  const Buffers buffers = bake(*thread, built, size);
  const Cells cells = cells_of(built, buffers, block);
  const std::vector<int32_t> chart = charts_of(cells, buffers);
  for (const int32_t start : {0, cells.count - 1}) {
    const std::vector<uint8_t> reached = flood(cells, start);
    for (size_t i = 0; i < reached.size(); ++i)
      EXPECT_EQ(reached[i] == 1, (chart[i] < 15) == (chart[at(start)] < 15)) << "cell " << i;
  }
}

// Two lobes of one chart side by side, `gap` texels apart, joined by a strip on top only.
Built comb(double left_texels, double gap_texels) {
  const double left = left_texels / size, right = left + gap_texels / size;
  const dvec2 bottom[] = {{0.1, 0.1}, {left, 0.1}, {right, 0.1}, {0.9, 0.1}},
              middle[] = {{0.1, 0.8}, {left, 0.8}, {right, 0.8}, {0.9, 0.8}},
              top[] = {{0.1, 0.9}, {left, 0.9}, {right, 0.9}, {0.9, 0.9}};
  Shape shape;
  for (const auto *row : {bottom, middle, top})
    for (int i = 0; i < 4; ++i) {
      // In space the lobes spread apart.
      const double away = row == bottom ? (i < 2 ? -0.5 : 0.5) : 0.0;
      shape.positions.push_back(vec3(row[i].x + away, row[i].y, 0));
    }
  for (const auto &[x, y] : {std::pair(0, 0), {2, 0}, {0, 1}, {1, 1}, {2, 1}}) {
    const int32_t a = 4 * y + x;
    for (const int32_t vertex : {a, a + 1, a + 5, a, a + 5, a + 4}) {
      shape.faces.push_back(vertex);
      const dvec2 uv = (vertex < 4 ? bottom : vertex < 8 ? middle : top)[vertex % 4];
      shape.uvs.push_back(vec2(uv));
    }
  }
  return build(shape);
}

TEST_F(CellsOfTexels, lobes_of_one_chart_are_not_joined_over_a_gap_below_a_texel) {
  for (const double left : {120.0, 120.1, 120.4, 120.6, 120.9}) // the gap between two texels' centers, on one, and beside it
    for (const double gap : {0.1, 0.4, 0.8}) {
      const Built built = comb(left, gap);
      ASSERT_EQ(built.charts.chart_count, 1);
      const Buffers buffers = bake(*thread, built, size);
      const Cells cells = cells_of(built, buffers, block);
      const int rows = static_cast<int>(0.8 * size) / block * block; // below lie the lobes alone
      std::set<int32_t> left_cells, right_cells;
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < size; ++x)
          if (buffers.triangle(x, y) >= 0 && cells.label[2 * at(y * size + x)] >= 0)
            (x + 0.5 < left + gap / 2 ? left_cells : right_cells).insert(cells.label[2 * at(y * size + x)]);
      ASSERT_FALSE(left_cells.empty() || right_cells.empty());
      for (const int32_t cell : left_cells) {
        EXPECT_FALSE(right_cells.contains(cell)) << "left lobe ends at " << left << ", gap " << gap;
        for (int32_t k = cells.adjacency_begin[at(cell)]; k < cells.adjacency_begin[at(cell) + 1]; ++k)
          EXPECT_FALSE(right_cells.contains(cells.adjacency[at(k)].x)) << "left lobe ends at " << left << ", gap " << gap;
      }
      EXPECT_EQ(std::ranges::count(flood(cells, 0), 1), cells.count) << "they are joined by the strip";
    }
}

TEST_F(CellsOfTexels, a_triangle_without_uv_area_is_carried_by_samples_of_its_own_area) {
  Shape shape = grid(3, 3, [](dvec2 position, int, int) { return dvec2(0.05) + position * 0.3; });
  const int32_t lost = 8; // the first triangle of the middle quad
  for (size_t corner = 0; corner < 3; ++corner) shape.uvs[3 * at(lost) + corner] = vec2(0.5f);
  const Built built = build(shape);
  const Buffers buffers = bake(*thread, built, size);
  const Cells cells = cells_of(built, buffers, block);
  EXPECT_EQ(cells.texelless, std::vector<int32_t>{lost});
  ASSERT_GE(cells.triangle_cell[at(lost)], 0);
  EXPECT_EQ(cells.texelless_begin[at(cells.triangle_cell[at(lost)]) + 1], 1) << "at the cell that leads to it";
  for (const float radius : {0.05f, 0.3f, 10.0f}) {
    const TexellessSamples samples = texelless_samples(cells, built, buffers, radius);
    ASSERT_EQ(samples.begin.size(), at(cells.count) + 1);
    ASSERT_EQ(samples.samples.size(), at(samples.begin.back()));
    double area = 0;
    dvec3 moment(0);
    for (const TexellessSample &sample : samples.samples) {
      area += static_cast<double>(sample.area);
      moment += dvec3(sample.position) * static_cast<double>(sample.area);
      EXPECT_NEAR(length(sample.normal), 1.0f, 1e-5f);
      EXPECT_EQ(sample.triangle, lost);
    }
    const dvec3 a(buffers.bake_space.to_buffer(built.position(24))), b(buffers.bake_space.to_buffer(built.position(25))),
        c(buffers.bake_space.to_buffer(built.position(26)));
    EXPECT_NEAR(area, 0.5 * length(glm::cross(b - a, c - a)), 1e-6) << "floats";
    EXPECT_LT(length(moment / area - (a + b + c) / 3.0), 1e-5) << "pieces are alike and spread evenly";
  }
}

TEST_F(CellsOfTexels, a_radius_as_small_as_floats_are_divides_a_triangle_without_uv_area_no_further_than_others) {
  Shape shape = grid(3, 3, [](dvec2 position, int, int) { return dvec2(0.05) + position * 0.3; });
  for (size_t corner = 0; corner < 3; ++corner) shape.uvs[24 + corner] = vec2(0.5f);
  const Built built = build(shape);
  const Buffers buffers = bake(*thread, built, size);
  const Cells cells = cells_of(built, buffers, block);
  const auto samples_of = [&](float radius) {
    std::vector<vec4> numbers;
    for (const TexellessSample &sample : texelless_samples(cells, built, buffers, radius).samples) {
      numbers.emplace_back(sample.position, sample.area);
      numbers.emplace_back(sample.normal, static_cast<float>(sample.triangle));
    }
    return numbers;
  };
  const std::vector<vec4> expected = samples_of(1e-3f);
  EXPECT_EQ(expected.size(), 2u * 16 * 16);
  for (const float radius : {1e-11f, 1e-30f, 0.0f}) EXPECT_EQ(samples_of(radius), expected) << radius;
}

TEST_F(CellsOfTexels, all_of_an_open_meshs_boundary_is_known_to_the_cells_along_it) {
  const Built built = build(grid(3, 3, [](dvec2 position, int, int) { return dvec2(0.05) + position * 0.3; }));
  const Cells cells = cells_of(built, bake(*thread, built, size), block);
  const std::set<int32_t> known(cells.boundary.begin(), cells.boundary.end());
  EXPECT_EQ(known.size(), 12u);
  for (const int32_t half_edge : known) EXPECT_EQ(built.half_edges.twin[at(half_edge)], -1);
}

} // namespace
} // namespace paradesc::test
