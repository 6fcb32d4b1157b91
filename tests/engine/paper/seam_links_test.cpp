// The maps over seams: exact everywhere on a plane, exact to first order on a curved surface.
#include "engine/paper/seam_links.h"

#include <cmath>

#include <gtest/gtest.h>

#include "bake/shapes.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

// M_e of one border.
struct Link {
  dmat2 linear;
  dvec2 from, to;
  double twin, chart;
  dvec2 operator()(dvec2 position) const { return to + linear * (position - from); }
};

Link link_of(const Built &built, const std::vector<vec4> &links, size_t border) {
  const dvec4 linear(links[2 * border]), rest(links[2 * border + 1]);
  const auto [first, second] = border_ends(built.charts, built.charts.borders[border]);
  return {dmat2(linear.x, linear.y, linear.z, linear.w), built.uv(first), dvec2(rest.x, rest.y), rest.z, rest.w};
}

Built torus_of_charts() {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 800});
  lay_out(mesh, {.charts = 15});
  return build(mesh);
}

// Calls check(border, twin, its link) for every seam.
template <class Check> int each_seam(const Built &built, const std::vector<vec4> &links, const Check &check) {
  int seams = 0;
  for (size_t i = 0; i < built.charts.borders.size(); ++i) {
    const Border &border = built.charts.borders[i];
    if (border.kind != BorderKind::seam) continue;
    ++seams;
    check(border, built.charts.borders[at(border.twin)], link_of(built, links, i));
  }
  return seams;
}

// Links are floats of (u, v) in [0, 1] and of ratios up to 10, with a few roundings.
constexpr double rounding = 5e-6;

TEST(SeamLinks, carry_the_ends_of_an_edge_onto_those_of_its_twin) {
  for (const Built &built : {plane_of_twelve_charts(), torus_of_charts()}) {
    const auto links = seam_links(built.triangles, built.charts);
    const int seams = each_seam(built, links, [&](const Border &border, const Border &twin, const Link &link) {
      EXPECT_LT(length(link(built.uv(border.half_edge)) - built.uv(next_corner(twin.half_edge))), rounding);
      EXPECT_LT(length(link(built.uv(next_corner(border.half_edge))) - built.uv(twin.half_edge)), rounding);
    });
    EXPECT_EQ(seams, 2 * built.charts.seam_edges);
  }
}

TEST(SeamLinks, name_the_twin_and_its_chart) {
  const Built built = plane_of_twelve_charts();
  each_seam(built, seam_links(built.triangles, built.charts), [&](const Border &border, const Border &twin, const Link &link) {
    EXPECT_EQ(link.twin, border.twin);
    EXPECT_EQ(link.chart, twin.chart);
  });
}

TEST(SeamLinks, are_exact_everywhere_on_a_plane) {
  const Built built = plane_of_twelve_charts();
  const int seams = each_seam(
      built, seam_links(built.triangles, built.charts), [&](const Border &border, const Border &twin, const Link &link) {
        const Affine near = chart_of_quad(border.chart % 4, border.chart / 4),
                     far = chart_of_quad(twin.chart % 4, twin.chart / 4);
        for (const dvec2 position : {dvec2(0, 0), dvec2(4, 0), dvec2(1, 3)}) // corners of the plane, several charts away
          EXPECT_LT(length(link(near(position)) - far(position)), 1e-4) << "an edge's roundings, four times as far away";
        const dvec2 third(vec2(built.position(previous_corner(twin.half_edge))));
        EXPECT_LT(length(link(near(third)) - built.uv(previous_corner(twin.half_edge))), rounding);
      });
  EXPECT_EQ(seams, 34); // 17 inner edges between 12 quads
}

TEST(SeamLinks, turn_over_where_one_of_the_two_charts_is_mirrored) {
  const Built built = plane_of_twelve_charts();
  int turned = 0;
  each_seam(built, seam_links(built.triangles, built.charts), [&](const Border &border, const Border &twin, const Link &link) {
    const bool mirrored = mirrored_quad(border.chart) != mirrored_quad(twin.chart);
    EXPECT_EQ(determinant(link.linear) < 0.0, mirrored);
    turned += mirrored;
  });
  EXPECT_GT(turned, 0);
}

TEST(SeamLinks, there_and_back_is_the_identity) {
  for (const Built &built : {plane_of_twelve_charts(), torus_of_charts()}) {
    const auto links = seam_links(built.triangles, built.charts);
    each_seam(built, links, [&](const Border &border, const Border &, const Link &link) {
      const Link back = link_of(built, links, at(border.twin));
      for (const dvec2 offset : {dvec2(0.0), dvec2(0.05, 0.0), dvec2(-0.02, 0.05)}) {
        const dvec2 position = built.uv(border.half_edge) + offset;
        EXPECT_LT(length(back(link(position)) - position), 1e-5); // two links, each rounded
      }
    });
  }
}

TEST(SeamLinks, lay_the_far_triangle_unfolded_into_the_near_ones_plane_onto_its_place) {
  const Built built = torus_of_charts();
  each_seam(built, seam_links(built.triangles, built.charts), [&](const Border &border, const Border &twin, const Link &link) {
    const int a = border.half_edge, b = next_corner(a), c = previous_corner(a), far = previous_corner(twin.half_edge);
    const dvec3 origin(built.position(a)), edge = glm::normalize(dvec3(built.position(b)) - origin);
    // Distance along the edge and from it, the near triangle on the left.
    auto unfolded = [&](int corner, double side) {
      const dvec3 spoke = dvec3(built.position(corner)) - origin;
      return dvec2(dot(spoke, edge), side * length(glm::cross(edge, spoke)));
    };
    const dmat2 plane(unfolded(b, 1.0), unfolded(c, 1.0)), chart(built.uv(b) - built.uv(a), built.uv(c) - built.uv(a));
    const dvec2 position = built.uv(a) + chart * inverse(plane) * unfolded(far, -1.0);
    EXPECT_LT(length(link(position) - built.uv(far)), rounding);
  });
}

TEST(SeamLinks, say_so_where_the_surface_ends_or_nothing_can_be_carried_over) {
  Shape shape = grid(3, 3, [](dvec2 position, int, int) { return position * 0.3; });
  const size_t inner = 2 * 4 * 3; // the first triangle of the middle quad
  for (size_t corner = inner; corner < inner + 3; ++corner) shape.uvs[corner] = vec2(0.5f);
  const Built built = build(shape);
  const auto links = seam_links(built.triangles, built.charts);
  ASSERT_EQ(links.size(), 2 * built.charts.borders.size());
  int boundary = 0, unlinked = 0;
  for (size_t i = 0; i < built.charts.borders.size(); ++i) {
    const BorderKind kind = built.charts.borders[i].kind;
    EXPECT_EQ(links[2 * i + 1].z, -1.0f - static_cast<float>(kind));
    boundary += kind == BorderKind::boundary;
    unlinked += kind == BorderKind::unlinked;
  }
  EXPECT_EQ(boundary, 12);
  EXPECT_EQ(unlinked, 3);
}

TEST(SeamLinks, a_border_runs_with_its_chart_on_the_left) {
  const Built built = plane_of_twelve_charts();
  for (const Border &border : built.charts.borders) {
    const auto [first, second] = border_ends(built.charts, border);
    EXPECT_GT(paradesc::cross(built.uv(second) - built.uv(first), built.uv(previous_corner(border.half_edge)) - built.uv(first)),
              0.0);
  }
}

} // namespace
} // namespace paradesc::test
