// The golden-angle pattern is even; its rotations are spread and repeatable.
#include "engine/paper/pattern.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace paradesc {
namespace {

TEST(Pattern, every_ring_of_equal_area_has_the_same_number_of_samples) {
  for (const int count : {16, 64, 256, 4096}) {
    std::vector<int> ring(16, 0);
    for (const vec2 position : golden_angle_pattern(count)) ++ring.at(static_cast<size_t>(16.0f * dot(position, position)));
    for (const int samples : ring) EXPECT_EQ(samples, count / 16) << "of " << count;
  }
}

TEST(Pattern, every_sector_has_nearly_the_same_number_of_samples) {
  for (const int count : {64, 256, 1000}) {
    std::vector<int> sector(8, 0);
    for (const vec2 position : golden_angle_pattern(count))
      ++sector.at(static_cast<size_t>(std::floor((std::atan2(position.y, position.x) / pi + 1.0) * 3.999999)));
    // Multiples of the golden angle leave an arc with at most a handful too many: their discrepancy grows with log(count).
    for (const int samples : sector) EXPECT_NEAR(samples, count / 8.0, 3.0) << "of " << count;
  }
}

TEST(Pattern, all_samples_lie_in_the_unit_disk_and_are_as_many_as_asked) {
  for (const int count : {1, 8, 77, 4096}) {
    const auto pattern = golden_angle_pattern(count);
    EXPECT_EQ(pattern.size(), static_cast<size_t>(count));
    for (const vec2 position : pattern) EXPECT_LT(length(position), 1.0f);
  }
}

TEST(Pattern, the_samples_center_is_the_disks) {
  for (const int count : {16, 64, 256, 4096}) {
    dvec2 sum(0.0);
    for (const vec2 position : golden_angle_pattern(count)) sum += dvec2(position);
    // Sums of unit vectors over multiples of the golden angle stay below 1 / (2 sin(half the angle)) + 1/2 < 1.1; radii only
    // grow.
    EXPECT_LT(length(sum) / count, 1.1 / count) << count;
  }
}

TEST(StratifiedPattern, every_cell_of_a_square_grid_has_one_sample) {
  for (const int side : {1, 4, 16, 64}) {
    std::vector<int> cell(static_cast<size_t>(side * side), 0);
    for (const vec2 position : stratified_pattern(side * side, 3)) {
      // Back from the disk: the ring is the square's, the angle runs along its sides.
      const double distance = length(dvec2(position)),
                   angle = std::atan2(static_cast<double>(position.y), static_cast<double>(position.x));
      const int side_number = static_cast<int>(std::floor(angle / (pi / 2) + 0.5));
      const double along = distance * (angle - side_number * pi / 2) * 4 / pi;
      const dvec2 turned = glm::dmat2(std::cos(side_number * pi / 2), std::sin(side_number * pi / 2),
                                      -std::sin(side_number * pi / 2), std::cos(side_number * pi / 2)) *
                           dvec2(distance, along);
      const auto column = static_cast<int>(std::floor((turned.x + 1) / 2 * side)),
                 row = static_cast<int>(std::floor((turned.y + 1) / 2 * side));
      ++cell.at(static_cast<size_t>(row * side + column));
    }
    for (const int samples : cell) EXPECT_EQ(samples, 1) << "of a side of " << side;
  }
}

TEST(StratifiedPattern, squares_become_disks_in_proportion_to_their_area) {
  for (double size = 0.1; size < 1; size += 0.1)
    for (double along = -1; along <= 1; along += 0.25) // the side of a square is a circle
      EXPECT_NEAR(length(concentric_disk(dvec2(size, along * size))), size, 1e-12);
  EXPECT_EQ(concentric_disk(dvec2(0)), dvec2(0));
}

TEST(StratifiedPattern, has_as_many_samples_as_asked_in_the_unit_disk_at_every_number) {
  for (int count = 1; count < 300; ++count) {
    const auto pattern = stratified_pattern(count, 0);
    EXPECT_EQ(pattern.size(), static_cast<size_t>(count));
    for (const vec2 position : pattern) EXPECT_LE(length(position), 1.0f) << count;
  }
}

// A quarter turn maps the grid's square onto itself: sectors of equal area have equal numbers, but for cells that their sides
// cut, of which there are about sqrt(count), half of them counted: three deviations of that.
TEST(StratifiedPattern, halves_of_even_and_odd_number_are_spread_over_rings_and_sectors) {
  for (const int count : {64, 77, 101, 256, 1000, 4096})
    for (int half = 0; half < 2; ++half) {
      std::vector<int> sector(8, 0), ring(4, 0);
      const auto pattern = stratified_pattern(count, 5);
      for (size_t i = static_cast<size_t>(half); i < pattern.size(); i += 2) {
        const vec2 position = pattern[i];
        ++sector.at(static_cast<size_t>(std::floor((std::atan2(position.y, position.x) / pi + 1.0) * 3.999999)));
        ++ring.at(std::min<size_t>(3, static_cast<size_t>(4.0f * dot(position, position))));
      }
      for (const int samples : sector) EXPECT_NEAR(samples, count / 16.0, 1 + 1.5 * std::pow(count, 0.25)) << count;
      for (const int samples : ring) EXPECT_NEAR(samples, count / 8.0, 1 + 3 * std::pow(count, 0.25)) << count;
    }
}

TEST(StratifiedPattern, is_that_of_the_seed) {
  EXPECT_EQ(stratified_pattern(100, 1), stratified_pattern(100, 1));
  EXPECT_NE(stratified_pattern(100, 1), stratified_pattern(100, 2));
}

TEST(Pattern, rotations_depend_on_the_point_and_the_seed) {
  std::set<float> angles;
  for (uint32_t point = 0; point < 100; ++point)
    for (uint32_t seed = 0; seed < 10; ++seed) angles.insert(pattern_rotation(point, seed));
  EXPECT_GE(angles.size(), 999u); // two of a thousand may meet in a float
}

TEST(Pattern, rotations_are_the_same_every_time) {
  for (const uint32_t point : {0u, 1u, 4000000000u}) EXPECT_EQ(pattern_rotation(point, 7), pattern_rotation(point, 7));
}

TEST(Pattern, rotations_are_spread_over_the_whole_turn) {
  std::vector<int> part(8, 0);
  for (uint32_t point = 0; point < 8000; ++point) {
    const float angle = pattern_rotation(point, 1);
    ASSERT_GE(angle, 0.0f);
    ASSERT_LE(angle, static_cast<float>(2 * pi));
    ++part.at(std::min<size_t>(7, static_cast<size_t>(angle / (2 * pi) * 8)));
  }
  for (const int points : part) EXPECT_NEAR(points, 1000, 150) << "five standard deviations of a fair draw";
}

} // namespace
} // namespace paradesc
