// The affine map over a seam edge, and the metric, on surfaces where both are known.
#include <gtest/gtest.h>

#include <cmath>

#include "bake/distortion.h"
#include "bake/seam_links.h"
#include "support/layout.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

struct Stages {
  Triangles triangles;
  HalfEdges half_edges;
  Charts charts;
  std::vector<vec4> links;
  explicit Stages(const TestMesh &mesh)
      : triangles(read_triangles(input_of(mesh))), half_edges(build_half_edges(triangles)),
        charts(build_charts(triangles, half_edges)), links(seam_links(triangles, charts)) {}

  vec2 uv(int corner) const { return triangles.corner_uv[static_cast<size_t>(corner)]; }
  vec2 carry(size_t border, vec2 place) const {
    const auto [first, second] = border_ends(triangles, charts.borders[border]);
    const glm::mat2 linear(vec2(links[2 * border].x, links[2 * border].y), vec2(links[2 * border].z, links[2 * border].w));
    return linear * (place - uv(first)) + vec2(links[2 * border + 1]);
  }
};

// A torus with irregular triangles on 15 charts, every third mirrored: no two maps alike.
Stages torus_of_many_charts() {
  TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 15});
  return Stages(mesh);
}

// Float UVs near 1 carry 6e-8; a map between charts of unlike scale takes that up to tenfold.
constexpr float rounding = 2e-6f;

TEST(SeamMap, takes_the_ends_of_an_edge_to_the_same_points_on_the_twin) {
  const Stages stages = torus_of_many_charts();
  int seams = 0;
  for (size_t i = 0; i < stages.charts.borders.size(); ++i) {
    const Border &border = stages.charts.borders[i];
    if (border.kind != BorderKind::seam) continue;
    ++seams;
    const int here = border.half_edge, there = stages.charts.borders[static_cast<size_t>(border.twin)].half_edge;
    EXPECT_LT(length(stages.carry(i, stages.uv(here)) - stages.uv(next_corner(there))), rounding);
    EXPECT_LT(length(stages.carry(i, stages.uv(next_corner(here))) - stages.uv(there)), rounding);
  }
  EXPECT_GT(seams, 100);
}

TEST(SeamMap, there_and_back_is_no_map) {
  const Stages stages = torus_of_many_charts();
  for (size_t i = 0; i < stages.charts.borders.size(); ++i) {
    const Border &border = stages.charts.borders[i];
    if (border.kind != BorderKind::seam) continue;
    const vec2 place = stages.uv(previous_corner(border.half_edge));
    EXPECT_LT(length(stages.carry(static_cast<size_t>(border.twin), stages.carry(i, place)) - place), 10 * rounding);
  }
}

TEST(SeamMap, turns_over_exactly_where_one_of_two_charts_is_mirrored) {
  const Stages stages = torus_of_many_charts();
  const auto orientation = [&](int half_edge) {
    const vec2 a = stages.uv(half_edge), b = stages.uv(next_corner(half_edge)), c = stages.uv(previous_corner(half_edge));
    return paradesc::cross(dvec2(b - a), dvec2(c - a)) > 0.0;
  };
  int turned = 0;
  for (size_t i = 0; i < stages.charts.borders.size(); ++i) {
    const Border &border = stages.charts.borders[i];
    if (border.kind != BorderKind::seam) continue;
    const vec4 m = stages.links[2 * i];
    const int there = stages.charts.borders[static_cast<size_t>(border.twin)].half_edge;
    EXPECT_EQ(m.x * m.w - m.y * m.z < 0.0f, orientation(border.half_edge) != orientation(there));
    turned += m.x * m.w - m.y * m.z < 0.0f;
  }
  EXPECT_GT(turned, 0);
}

TEST(SeamMap, says_where_the_surface_ends) {
  TestMesh mesh = plane(2, 1, {.vertices = 100});
  lay_out(mesh, {.charts = 1});
  const Stages stages(mesh);
  ASSERT_GT(stages.charts.borders.size(), 0u);
  for (size_t i = 0; i < stages.charts.borders.size(); ++i)
    EXPECT_EQ(stages.links[2 * i + 1].z, -1.0f - static_cast<float>(BorderKind::boundary));
}

// A plane of width 2 laid out without warp: one similarity for the whole chart, so E = G, F = 0, and the ellipse is a circle.
TEST(Distortion, is_that_of_a_similarity_on_a_plane) {
  TestMesh mesh = plane(2, 1, {.vertices = 200});
  lay_out(mesh, {.charts = 1});
  const Stages stages(mesh);
  const BufferFrame frame = frame_of(stages.triangles, stages.half_edges);
  EXPECT_NEAR(frame.scale, 1.0, 1e-6); // the longest half side is 1 already
  const std::vector<vec4> forms = first_fundamental_forms(stages.triangles, stages.charts, frame, 1);
  // Float positions and UVs over edges of a fifteenth of the mesh: 1e-5 of the metric.
  for (const vec4 form : forms) {
    EXPECT_NEAR(form.x, forms[0].x, 1e-4f * forms[0].x);
    EXPECT_NEAR(form.z, forms[0].x, 1e-4f * forms[0].x);
    EXPECT_NEAR(form.y, 0.0f, 1e-4f * forms[0].x);
    EXPECT_NEAR(form.w, forms[0].x, 1e-4f * forms[0].x);
  }
  for (const vec4 ellipse : sampling_ellipses(stages.triangles, stages.charts, forms)) {
    EXPECT_NEAR(ellipse.x * std::sqrt(forms[0].x), 1.0f, 1e-3f);
    EXPECT_NEAR(ellipse.w * std::sqrt(forms[0].x), 1.0f, 1e-3f);
    EXPECT_NEAR(ellipse.y * std::sqrt(forms[0].x), 0.0f, 1e-3f);
  }
}

} // namespace
} // namespace paradesc::test
