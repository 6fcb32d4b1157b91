// shaders/kernel as C++: what eight lanes add up is what one adds up after the other, for every row of the registry.
#include "engine/kernels/recorded.h"

#include <gtest/gtest.h>

#include "descriptor/registry.h"
#include "support/likeness.h"

namespace paradesc::test {
namespace {

// part: of what is usual, for sums of some hundred floats in another order.
template <template <class, class> class Kernel> void expect_lanes_add_up(double part) {
  int defined = 0;
  for (const Recorded &recorded : recorded_neighborhoods()) {
    SCOPED_TRACE(recorded.name);
    const std::vector<float> one = one_at_a_time<Kernel>(recorded), eight = eight_at_a_time<Kernel>(recorded);
    defined += expect_like(eight, one, usual_values(), part);
  }
  EXPECT_GT(defined, 200) << "values that exist";
}

TEST(Kernels, add_eight_neighbors_at_a_time_by_the_shape_operator) { expect_lanes_add_up<kernels::ShapeOperatorKernel>(1e-5); }
TEST(Kernels, add_eight_neighbors_at_a_time_by_the_integrals) { expect_lanes_add_up<kernels::IntegralKernel>(5e-5); }
TEST(Kernels, add_eight_neighbors_at_a_time_by_two_windows) {
  expect_lanes_add_up<kernels::ExtrapolatedKernel>(1e-4); // differences, and roots of them
}

TEST(Kernels, know_how_a_paraboloid_bends) {
  const std::vector<float> values = one_at_a_time<kernels::ShapeOperatorKernel>(recorded_neighborhoods()[0]);
  const auto of = [&](const char *name) { return values[static_cast<size_t>(find_descriptor(name))]; };
  // z = -(3 x^2 + 2.5 y^2)/2 bends by 3 and 2.5 in its middle, and less where it is steep: by 1 / (1 + 9 r^2)^1.5 at most.
  const double least = std::pow(1.09, -1.5);
  EXPECT_LT(of("gaussian_curvature"), 7.5);
  EXPECT_GT(of("gaussian_curvature"), 7.5 * least * least);
  EXPECT_LT(std::abs(of("mean_curvature")), 2.75);
  EXPECT_GT(std::abs(of("mean_curvature")), 2.75 * least);
}

TEST(Kernels, directions_are_unit_vectors_however_flat_the_surface_is) {
  using Kernel = kernels::ShapeOperatorKernel<float, bool>;
  Kernel kernel{EvaluateParams{}};
  Kernel::Sums sums;
  kernel.sums_init(sums, {}, {0.6f, 0.0f, 0.8f}, 0.0f);
  for (const float size : {1.0f, 1e-12f, 1e-20f, 1e-23f, 1e-30f, 1e-40f, 0.0f}) {
    Kernel::Neighborhood neighborhood = kernel.unfitted_neighborhood(1.0f, 1.0f);
    neighborhood.shape = {0.3f * size, 0.7f * size, -0.9f * size};
    kernel.find_directions(sums.center, neighborhood);
    // The rounding of some floats. Squares of 1e-20 lose digits, and lengths were off by up to a tenth.
    EXPECT_NEAR(length(neighborhood.direction_max), 1.0f, 1e-6f) << size;
    EXPECT_NEAR(length(neighborhood.direction_min), 1.0f, 1e-6f) << size;
    EXPECT_NEAR(dot(neighborhood.direction_max, neighborhood.direction_min), 0.0f, 1e-6f) << size;
  }
}

} // namespace
} // namespace paradesc::test
