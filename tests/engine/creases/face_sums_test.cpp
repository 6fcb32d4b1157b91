// Sums over triangles in lanes: the same bits for every set of instructions, and functions of lanes against those of the library.
#include "engine/creases/face_sums.h"

#include <array>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "engine/creases/lane_functions.h"
#include "engine/creases/solid.h"
#include "support/creases.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

TEST(LaneFunctions, are_those_of_the_library) {
  Random random(5);
  for (int i = 0; i < 100000; ++i) {
    const auto x = static_cast<float>(std::exp(random.uniform(-50, 50)));
    const double logarithm = std::log(static_cast<double>(x));
    ASSERT_NEAR(kernels::logarithm(kernels::Lanes(x)).lane[0], logarithm, 2e-7 * std::max(1.0, std::abs(logarithm))) << x;
    const auto across = static_cast<float>(random.uniform(-1, 1)),
               up = static_cast<float>(random.uniform(-1, 1) * std::exp(random.uniform(-20, 0)));
    for (const auto &[a, b] : {std::array{up, across}, std::array{across, up}})
      ASSERT_NEAR(kernels::angle(kernels::Lanes(a), kernels::Lanes(b)).lane[0],
                  std::atan2(static_cast<double>(a), static_cast<double>(b)), 4e-7)
          << a << " " << b;
  }
  EXPECT_EQ(kernels::logarithm(kernels::Lanes(1.0f)).lane[0], 0.0f);
  EXPECT_EQ(kernels::angle(kernels::Lanes(0.0f), kernels::Lanes(0.0f)).lane[0], 0.0f);
}

// A cylinder whose normals turn, so that all kinds of terms are there, at balls of a few triangles and of many.
TEST(FaceSums, have_the_same_bits_for_all_instructions) {
  const Triangles triangles = prism(40, 30, 30);
  const HalfEdges half_edges = build_half_edges(triangles);
  const Creases creases = creases_of(triangles, half_edges);
  const Normals normals =
      compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges, creases), PDESC_NORMALS_FITTED, 0);
  const Facets facets = find_facets(triangles, half_edges, normals, creases);
  for (const double radius : {0.06, 0.2, 0.7}) {
    SolidSurface shared({triangles, half_edges, normals, creases, facets}, radius);
    int beside = 0;
    for (int32_t point = 0; point < half_edges.point_count; point += 11) {
      const dvec3 position(triangles.positions[half_edges.point_vertex[point]]),
          normal = glm::normalize(dvec3(normals.point[point])), t1 = tangent_of(normal);
      std::array<double, 4> first{};
      for (const FaceTarget &target : face_targets()) {
        shared.target = target;
        SolidMeasure measure(shared);
        measure.is_near_crease(position, half_edges.point_half_edge[point] / 3);
        const SolidTensor found =
            measure.at({position, normal, t1, glm::cross(normal, t1), half_edges.point_half_edge[point] / 3, point});
        const std::array<double, 4> values{found.weight, found.xx, found.xy, found.yy};
        if (target.name == face_targets()[0].name) first = values;
        ASSERT_EQ(std::memcmp(values.data(), first.data(), sizeof first), 0) << target.name << " at " << point << ", " << radius;
        beside += found.weight > 0;
      }
    }
    EXPECT_GT(beside, 20);
  }
}

} // namespace
} // namespace paradesc::test
