// Operators on maps by the engine on the CPU: whose map is not computed twice where the surface's pass has it.
#include <string>
#include <vector>

#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

// The pass over the surface divides it as finely as its other descriptors allow, and the map's own pass as the map alone needs.
TEST(CpuOperators, have_the_same_bits_whatever_else_is_asked) {
  std::string why_not;
  const Context cpu = open_context(PDESC_BACKEND_CPU, why_not);
  ASSERT_TRUE(cpu) << why_not;
  const TestMesh mesh = torus(1, 0.4, {.vertices = 3000});
  for (const char *map : {"mean_curvature", "sphere_volume_normalized"})
    for (const int32_t estimator : {PDESC_ESTIMATOR_SHAPE_OPERATOR, PDESC_ESTIMATOR_INTEGRAL, PDESC_ESTIMATOR_EXTRAPOLATED}) {
      const Settings settings{.radius = 0.1, .estimator = estimator, .map_descriptor = map};
      const Results alone = compute(cpu.get(), mesh, settings, std::vector<std::string>{"gradient_magnitude"});
      for (const char *other : {"mean_curvature", "sphere_volume_normalized", "geodesic_area"}) {
        const Results beside = compute(cpu.get(), mesh, settings, std::vector<std::string>{"gradient_magnitude", other, map});
        EXPECT_EQ(beside["gradient_magnitude"], alone["gradient_magnitude"]) << map << " beside " << other;
      }
    }
}

} // namespace
} // namespace paradesc::test
