// A surface that was divided for its maps: its kept arrays, and how long they are kept.
#include "compute/refine.h"

#include <string>
#include <utility>
#include <vector>

#include "engine/engines.h"
#include "support/api_fixture.h"

namespace paradesc {
namespace {

class Refine : public ::testing::Test {
protected:
  void SetUp() override {
    ball = test::sphere(1, {.vertices = 400});
    test::lay_out(ball, {.charts = 6});
    pdesc_options_init(&options);
    options.radius = 0.1;
    pdesc_context_options requested;
    pdesc_context_options_init(&requested);
    requested.backend = PDESC_BACKEND_CPU;
    mesh = make_mesh(make_context(requested), input_of(ball));
    displace(64, 0.1f);
  }
  void displace(int width, float height) {
    const std::vector<float> heights(static_cast<size_t>(64 * width), height);
    set_displacement(mesh->maps, mesh->triangles, heights.data(), width, 64, 0.0, 1.0);
  }
  // The number of the division, and where its last point is.
  std::pair<uint64_t, vec3> made() {
    const Surface surface = refined_surface_of(*mesh, options);
    return {surface.topology_version, surface.triangles.positions.back()};
  }

  test::TestMesh ball;
  pdesc_options options;
  std::unique_ptr<Mesh> mesh;
};

TEST_F(Refine, keeps_the_pieces_while_they_would_be_the_same) {
  const auto first = made();
  EXPECT_GT(refined_surface_of(*mesh, options).triangles.triangle_count, 2 * mesh->triangles.triangle_count);
  EXPECT_EQ(made(), first);
  displace(64, 0.2f);
  const auto higher = made();
  EXPECT_EQ(higher.first, first.first) << "another image of the same size";
  EXPECT_NE(higher.second, first.second);
  for (float &position : ball.positions) position *= 1.0f + 1e-4f;
  move_mesh(*mesh, ball.positions.data(), ball.vertex_count);
  const auto moved = made();
  EXPECT_EQ(moved.first, first.first) << "other positions, with a radius that goes with them";
  EXPECT_NE(moved.second, higher.second);
}

TEST_F(Refine, makes_other_pieces_for_another_radius_and_another_size) {
  const auto first = made();
  options.radius = 0.5; // less than the pixels ask for
  const auto coarser = made();
  EXPECT_NE(coarser.first, first.first);
  options.radius = 0.1;
  displace(16, 0.1f);
  EXPECT_NE(made().first, coarser.first);
}

TEST_F(Refine, forgets_it_all) {
  made();
  forget_refined_surface(*mesh);
  EXPECT_FALSE(mesh->division.key());
  EXPECT_FALSE(mesh->division_plan.key());
  EXPECT_FALSE(mesh->refined.key());
}

TEST_F(Refine, is_for_those_who_do_not_follow_maps_themselves) {
  for (const int32_t backend : {int32_t{PDESC_BACKEND_CPU}, int32_t{PDESC_BACKEND_REFERENCE}, test::device_backend()}) {
    const bool divided = backend != test::device_backend();
    EXPECT_EQ(is_divided(*mesh, backend), divided);
  }
  mesh->maps.displacement.reset();
  EXPECT_FALSE(is_divided(*mesh, PDESC_BACKEND_CPU));
}

} // namespace
} // namespace paradesc
