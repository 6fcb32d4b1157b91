// The metric of parameterizations that are known in closed form.
#include "bake/distortion.h"

#include <cmath>

#include <gtest/gtest.h>

#include "bake/shapes.h"

namespace paradesc::test {
namespace {

constexpr double along = 2, across = 3,
                 turn = pi / 6; // stretch from (u, v) to space, along a direction 30 degrees off the u axis

// A patch of the unit square, turned in (u, v), stretched, and tilted in space: P(u, v) is linear.
dvec3 surface(dvec2 uv) {
  const double c = std::cos(turn), s = std::sin(turn);
  const double x = along * (c * uv.x + s * uv.y), y = across * (-s * uv.x + c * uv.y);
  return dvec3(0.6 * x, y, 0.8 * x); // an isometry of the plane
}

Built stretched_patch() {
  Shape shape = grid(3, 3, [](dvec2 position, int, int) { return dvec2(0.1) + position * 0.25; });
  for (vec3 &position : shape.positions) position = vec3(surface(dvec2(0.1) + dvec2(position.x, position.y) * 0.25));
  return build(shape);
}

std::vector<vec4> forms_of(const Built &built, const BakeSpace &bake_space = {}) {
  std::vector<vec4> forms;
  for (size_t t = 0; t < at(built.triangles.triangle_count); ++t)
    forms.push_back(form_of(built.triangles, built.charts, bake_space, t));
  return forms;
}

TEST(FirstFundamentalForm, is_that_of_the_affine_map) {
  const Built built = stretched_patch();
  const double c = std::cos(turn), s = std::sin(turn);
  for (const vec4 form : forms_of(built)) {
    // Positions and UVs are floats, edges a tenth of them: 1e-5 is about ten roundings.
    EXPECT_NEAR(form.x, along * along * c * c + across * across * s * s, 1e-4);
    EXPECT_NEAR(form.y, (along * along - across * across) * c * s, 1e-4);
    EXPECT_NEAR(form.z, along * along * s * s + across * across * c * c, 1e-4);
    EXPECT_NEAR(form.w, along * across, 1e-4);
  }
}

TEST(FirstFundamentalForm, is_in_buffer_units) {
  const Built built = stretched_patch();
  const BakeSpace bake_space = bake_space_of(bounding_box(built.triangles, built.half_edges));
  const auto plain = forms_of(built);
  const auto scaled = forms_of(built, bake_space);
  const auto square = static_cast<float>(bake_space.scale * bake_space.scale);
  ASSERT_NE(square, 1.0f);
  for (size_t i = 0; i < plain.size(); ++i)
    for (int k = 0; k < 4; ++k)
      EXPECT_NEAR(scaled[i][k], plain[i][k] * square, 1e-6 * std::abs(plain[i][k] * square)); // one rounding
}

TEST(FirstFundamentalForm, area_elements_times_uv_areas_are_areas) {
  const Built built = stretched_patch();
  const auto forms = forms_of(built);
  for (int t = 0; t < built.triangles.triangle_count; ++t) {
    const vec3 a = built.position(3 * t), b = built.position(3 * t + 1), c = built.position(3 * t + 2);
    const double uv_area =
        0.5 * std::abs(paradesc::cross(built.uv(3 * t + 1) - built.uv(3 * t), built.uv(3 * t + 2) - built.uv(3 * t)));
    const double area = 0.5 * length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
    EXPECT_NEAR(static_cast<double>(forms[at(t)].w) * uv_area, area, 1e-6 * area); // a form is rounded to float once
  }
}

TEST(BakeSpace, puts_the_longest_side_of_the_box_between_minus_one_and_one) {
  const Built built = build(grid(4, 2, [](dvec2 position, int, int) { return position * 0.2; }));
  const BakeSpace bake_space = bake_space_of(bounding_box(built.triangles, built.half_edges));
  EXPECT_EQ(bake_space.to_buffer(vec3(0, 0, 0)), vec3(-1, -0.5f, 0));
  EXPECT_EQ(bake_space.to_buffer(vec3(4, 2, 0)), vec3(1, 0.5f, 0));
}

TEST(BakeSpace, leaves_out_vertices_without_a_face) {
  Shape shape = grid(4, 2, [](dvec2 position, int, int) { return position * 0.2; });
  shape.positions.push_back(vec3(1000));
  const Built built = build(shape);
  EXPECT_EQ(bake_space_of(bounding_box(built.triangles, built.half_edges)).to_buffer(vec3(4, 2, 0)), vec3(1, 0.5f, 0));
}

TEST(SamplingEllipse, carries_the_unit_circle_to_offsets_of_length_one_on_the_surface) {
  const Built built = stretched_patch();
  const auto ellipses = sampling_ellipses(built.triangles, built.charts, {});
  ASSERT_EQ(ellipses.size(), 16u);
  for (const vec4 ellipse : ellipses)
    for (int k = 0; k < 24; ++k) {
      const dvec2 direction(std::cos(k * pi / 12), std::sin(k * pi / 12));
      const dvec2 offset = dmat2(ellipse.x, ellipse.y, ellipse.z, ellipse.w) * direction;
      EXPECT_NEAR(length(surface(offset)), 1.0, 1e-5) << k; // floats: the forms are good to about 1e-6
    }
}

TEST(SamplingEllipse, is_zero_where_no_triangle_has_area) {
  Built built = stretched_patch();
  for (vec3 &position : built.triangles.positions) position = vec3(1.0f);
  for (const vec4 ellipse : sampling_ellipses(built.triangles, built.charts, {})) EXPECT_EQ(ellipse, vec4(0.0f));
}

} // namespace
} // namespace paradesc::test
