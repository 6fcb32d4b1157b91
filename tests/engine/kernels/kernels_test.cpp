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

} // namespace
} // namespace paradesc::test
