// UV maps with more area than their square → a layout of their own before the first triangle is drawn.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "compute/compute.h"
#include "context.h"
#include "support/error.h"
#include "support/layout.h"
#include "support/run.h"

namespace paradesc::test {
namespace {

// Every two triangles on the whole square, as Blender's Reset leaves quads.
TestMesh reset(TestMesh mesh) {
  const std::vector<float> corners{0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1};
  mesh.corner_uvs.resize(2 * mesh.corner_vertices.size());
  for (size_t i = 0; i < mesh.corner_uvs.size(); ++i) mesh.corner_uvs[i] = corners[i % corners.size()];
  return mesh;
}

// Half of its area lies on the other half, within the square.
TestMesh folded(TestMesh mesh) {
  for (size_t i = 0; i < mesh.corner_uvs.size(); i += 2)
    if (mesh.corner_uvs[i] > 0.5f) mesh.corner_uvs[i] = 1.0f - mesh.corner_uvs[i];
  return mesh;
}

class Crowded : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    if (!open_context(device_backend(), why_not)) GTEST_SKIP() << why_not;
    pdesc_context_options requested;
    pdesc_context_options_init(&requested);
    requested.backend = device_backend();
    context = make_context(requested);
    ball = sphere(1.0, {.vertices = 300});
    lay_out(ball, {});
  }

  // A mesh whose first run was cancelled just before it baked.
  std::unique_ptr<paradesc::Mesh> before_drawing(const TestMesh &mesh) const {
    auto native = paradesc::make_mesh(context, input_of(mesh));
    const std::vector<int> rows{0};
    const auto stop = [](const char *stage, double) { return std::string(stage) != "bake"; };
    EXPECT_THROW(paradesc::compute(*native, options_of(settings), rows, stop), Error);
    return native;
  }

  std::shared_ptr<paradesc::Context> context;
  Settings settings{.radius = 0.1, .samples = 64, .buffer_size = 256};
  TestMesh ball;
};

TEST_F(Crowded, faces_that_each_fill_the_square_are_laid_out_before_they_are_drawn) {
  const auto native = before_drawing(reset(ball));
  EXPECT_EQ(native->atlases.current().layout, PDESC_LAYOUT_OVERLAPS);
  const std::vector<int> rows{0};
  const paradesc::Field field = paradesc::compute(*native, options_of(settings), rows, [](const char *, double) { return true; });
  EXPECT_EQ(field.report.private_layout, PDESC_LAYOUT_OVERLAPS);
  EXPECT_EQ(field.report.overlapping_texels, 0);
}

TEST_F(Crowded, what_fits_into_the_square_is_drawn_before_it_is_searched) {
  for (const TestMesh &mesh : {ball, folded(ball)}) {
    const auto native = before_drawing(mesh);
    EXPECT_EQ(native->atlases.current().layout, PDESC_LAYOUT_GIVEN);
    EXPECT_FALSE(native->atlases.known_free_of_overlaps());
  }
}

} // namespace
} // namespace paradesc::test
