// The direction of k1.
#include "support/run.h"

#include <iostream>

#include "descriptors/directions.h"
#include "support/layout.h"

namespace paradesc::test {
namespace {

class PrincipalDirectionMax : public OnBackend {};
PDESC_ON_EACH_BACKEND(PrincipalDirectionMax);

// Issue "All of the paper": a mean angle of 1 degree at most.
TEST_P(PrincipalDirectionMax, torus_has_it_around_the_tube) {
  TestMesh mesh = torus(1, 0.4);
  lay_out(mesh, {.charts = 15});
  const double angle = mean_angle_to(directions_of_torus(mesh).largest, mesh, compute_one(mesh, "principal_direction_max", {}));
  std::cout << "mean angle " << angle << " degrees\n";
  EXPECT_LE(angle, 1);
}

TEST_P(PrincipalDirectionMax, ellipsoid_has_it_where_the_derivative_of_the_normal_is_largest) {
  const double a = 1, b = 0.75, c = 0.5;
  TestMesh mesh = ellipsoid(a, b, c);
  lay_out(mesh, {.charts = 15});
  const double angle =
      mean_angle_to(directions_of_ellipsoid(mesh, a, b, c).largest, mesh, compute_one(mesh, "principal_direction_max", {}));
  std::cout << "mean angle " << angle << " degrees\n";
  EXPECT_LE(angle, 1);
}

} // namespace
} // namespace paradesc::test
