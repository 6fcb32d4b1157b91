// The displaced surface as triangles: where its points go, and its normals.
#include "bake/refined_surface.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "bake/shapes.h"
#include "support/error.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

// A sphere whose charts have nothing to do with each other in the image.
class Refined : public ::testing::Test {
protected:
  void SetUp() override {
    mesh = sphere(1, {.vertices = 400});
    lay_out(mesh, {.charts = 6});
    built = build(mesh);
    space = bake_space_of(bounding_box(built.triangles, built.half_edges));
    normals = compute_normals(built.triangles, built.half_edges, build_normal_rings(built.triangles, built.half_edges),
                              PDESC_NORMALS_FITTED, 0);
  }

  void displace(float scale) {
    Random random(1);
    std::vector<float> heights(64 * 64);
    for (float &height : heights) height = static_cast<float>(random.uniform());
    set_displacement(maps, built.triangles, heights.data(), 64, 64, 0.5, static_cast<double>(scale));
  }

  void refine() {
    const MeasureTriangle measure = measure_of_maps(maps, built.triangles, 0.2);
    division = divide(built.half_edges, plan_division(built.half_edges, measure, most_pieces, 2), 2);
    refined = refine_surface(maps, built.triangles, built.half_edges, normals, space, division, 2);
  }

  vec3 in_buffer(size_t point) const { return space.to_buffer(refined.triangles.positions[point]); }

  TestMesh mesh;
  Built built;
  BakeSpace space;
  Normals normals;
  SurfaceMaps maps;
  Division division;
  RefinedSurface refined;
};

constexpr double rounding = 1e-6; // of floats, to the units of the positions and back

TEST_F(Refined, points_of_the_mesh_are_the_first_and_go_where_the_device_takes_them) {
  displace(0.1f);
  refine();
  const DisplacedPoints expected = displace_points(maps, built.triangles, built.half_edges, normals, space, 2);
  ASSERT_GT(division.half_edges.point_count, 2 * built.half_edges.point_count);
  for (size_t point = 0; point < expected.position.size(); ++point) {
    ASSERT_LT(glm::length(in_buffer(point) - expected.position[point]), rounding);
    ASSERT_EQ(refined.normals.point[point], expected.normal[point]);
  }
}

TEST_F(Refined, points_on_edges_go_to_the_mean_of_where_both_triangles_take_them) {
  displace(0.1f);
  refine();
  const DisplacedSurface surface(maps, built.triangles, normals, space);
  const DivisionPlan &plan = division.plan;
  int on_seams = 0;
  for (int32_t h = 0; h < static_cast<int32_t>(built.half_edges.twin.size()); ++h) {
    const int32_t twin = built.half_edges.twin[at(h)], parts = 1 << plan.halvings[at(h)];
    ASSERT_GE(twin, 0);
    if (twin < h) continue;
    for (int32_t k = 1; k < parts; ++k) {
      const auto along = [&](int32_t half_edge, double part) {
        vec3 weights(0.0f);
        weights[half_edge % 3] = static_cast<float>(1 - part);
        weights[next_corner(half_edge) % 3] = static_cast<float>(part);
        return surface.at(half_edge / 3, weights.y, weights.z);
      };
      const double part = static_cast<double>(k) / parts;
      const SurfacePoint here = along(h, part), there = along(twin, 1 - part);
      const auto point = at(built.half_edges.point_count + plan.edge_begin[at(h)] + k - 1);
      ASSERT_LT(glm::length(in_buffer(point) - 0.5f * (here.position + there.position)), rounding);
      ASSERT_LT(glm::length(refined.normals.point[point] - normalize(here.normal + there.normal)), 1e-5f);
      on_seams += glm::length(here.position - there.position) > 0.01f;
    }
  }
  EXPECT_GT(on_seams, 50) << "the charts' heights are to differ there";
}

TEST_F(Refined, corners_of_pieces_have_the_normals_of_their_own_triangle) {
  displace(0.1f);
  refine();
  const DisplacedSurface surface(maps, built.triangles, normals, space);
  for (int32_t triangle = 0; triangle < built.triangles.triangle_count; ++triangle)
    for (int32_t h = 3 * division.plan.piece_begin[at(triangle)]; h < 3 * division.plan.piece_begin[at(triangle) + 1]; ++h) {
      const vec2 weights = division.fan_weights[at((*division.corner_fan)[at(h)])];
      ASSERT_EQ(refined.normals.corner(at(h)), surface.at(triangle, weights.x, weights.y).normal);
    }
}

TEST_F(Refined, is_as_fine_as_the_larger_of_the_images) {
  displace(0.1f);
  const auto pieces = [&] {
    const MeasureTriangle measure = measure_of_maps(maps, built.triangles, 0.01);
    return plan_division(built.half_edges, measure, most_pieces, 2).pieces();
  };
  const int32_t of_heights = pieces();
  const std::vector<float> rgb(size_t{3} * 256 * 16, 0.5f), tangents(4 * mesh.corner_vertices.size(), 0.5f);
  set_normal_map(maps, built.triangles, rgb.data(), 256, 16, tangents.data(), static_cast<int32_t>(mesh.corner_vertices.size()));
  EXPECT_GT(pieces(), 2 * of_heights) << "four times as many pixels across";
  maps.displacement.reset();
  EXPECT_GT(pieces(), of_heights / 2) << "and fewer along";
}

TEST_F(Refined, is_refused_where_it_would_be_out_of_bounds) {
  displace(1e30f);
  EXPECT_THROW(refine(), Error);
  displace(0.1f);
  EXPECT_NO_THROW(refine());
  const float rgb[] = {3e38f, 0.5f, 0.5f};
  const std::vector<float> tangents(4 * mesh.corner_vertices.size(), 1.0f);
  set_normal_map(maps, built.triangles, rgb, 1, 1, tangents.data(), static_cast<int32_t>(mesh.corner_vertices.size()));
  EXPECT_THROW(refine(), Error) << "normals that are no numbers";
}

} // namespace
} // namespace paradesc::test
