// Results at points → values and masks of vertices, on results made by hand.
#include "gather/field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace paradesc {
namespace {

const std::vector<int> rows = {0}; // one of one component
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// Every vertex is a point of its own, except those with point -1.
HalfEdges one_point_each(std::vector<int32_t> vertex_point) {
  HalfEdges half_edges;
  half_edges.point_count = 0;
  for (const int32_t point : vertex_point) half_edges.point_count = std::max(half_edges.point_count, point + 1);
  half_edges.vertex_point = std::move(vertex_point);
  return half_edges;
}

CenterResults at_four_points() {
  CenterResults results;
  results.values = {{2.0f, 7.0f, nan, 3.0f}};
  results.coverage = {1.0f, 0.89f, 0.2f, 0.9f};
  results.boundary = {0, 1, 0, 0};
  return results;
}

TEST(Field, a_vertex_has_value_coverage_and_mask_of_its_point) {
  Field field;
  gather(one_point_each({0, 1, 2, 3, -1}), at_four_points(), rows, 1, field);
  EXPECT_EQ(field.values.at(0).at(0), 2.0f);
  EXPECT_EQ(field.values.at(0).at(1), 7.0f);
  EXPECT_EQ(field.values.at(1).at(2), 0.2f);
  const std::vector<uint8_t> mask = {0, PDESC_MASK_BOUNDARY | PDESC_MASK_LOW_COVERAGE, PDESC_MASK_LOW_COVERAGE, 0,
                                     PDESC_MASK_NO_FACE};
  EXPECT_EQ(field.mask, mask) << "coverage is low below 0.9";
  EXPECT_EQ(field.report.boundary_vertices, 1);
  EXPECT_EQ(field.report.low_coverage_vertices, 2);
}

TEST(Field, a_point_without_coverage_has_no_texel) {
  CenterResults results = at_four_points();
  results.coverage[3] = nan;
  Field field;
  gather(one_point_each({0, 1, 2, 3}), results, rows, 1, field);
  EXPECT_EQ(field.mask.at(3), PDESC_MASK_NO_TEXEL);
  EXPECT_TRUE(std::isnan(field.values.at(0).at(3)));
}

} // namespace
} // namespace paradesc
