// Facets beside creases: made when a descriptor asks for them, and kept while nothing that they are of has changed.
#include <string>
#include <vector>

#include "compute/compute.h"
#include "descriptor/registry.h"
#include "support/api_fixture.h"
#include "support/solids.h"

namespace paradesc {
namespace {

class FacetsStage : public ::testing::TestWithParam<int32_t> {
protected:
  void SetUp() override {
    triangles = test::box(6);
    pdesc_mesh_input input;
    pdesc_mesh_input_init(&input);
    input.vertex_count = triangles.vertex_count;
    input.triangle_count = triangles.triangle_count;
    input.corner_count = 3 * triangles.triangle_count;
    input.positions = &triangles.positions[0].x;
    input.corner_vertices = triangles.corner_vertex.data();
    std::vector<int32_t> corners;
    for (int32_t i = 0; i < input.corner_count; ++i) corners.push_back(i);
    input.triangle_corners = corners.data();
    pdesc_context_options requested;
    pdesc_context_options_init(&requested);
    requested.backend = GetParam();
    mesh = make_mesh(make_context(requested), input);
    pdesc_options_init(&options);
    options.radius = 0.1;
  }
  void compute_on(const char *name) {
    compute(*mesh, options, std::vector<int>{find_descriptor(name)}, [](const char *, double) { return true; });
  }

  Triangles triangles;
  pdesc_options options;
  std::unique_ptr<Mesh> mesh;
};

TEST_P(FacetsStage, is_made_for_curvature_alone_and_once) {
  compute_on("euclidean_area");
  EXPECT_FALSE(mesh->facets.key()) << "an area is what it is";
  compute_on("mean_curvature");
  ASSERT_TRUE(mesh->facets.key());
  const Facet *const made = mesh->facets.value().facet.data();
  options.radius = 0.12;
  options.estimator = PDESC_ESTIMATOR_EXTRAPOLATED;
  compute_on("mean_curvature");
  EXPECT_EQ(mesh->facets.value().facet.data(), made);
  const auto key = mesh->facets.key();
  for (vec3 &position : triangles.positions) position *= 1.5f;
  move_mesh(*mesh, &triangles.positions[0].x, triangles.vertex_count);
  compute_on("mean_curvature");
  EXPECT_NE(mesh->facets.key(), key);
}

INSTANTIATE_TEST_SUITE_P(, FacetsStage, ::testing::Values(int32_t{PDESC_BACKEND_CPU}, int32_t{PDESC_BACKEND_REFERENCE}),
                         test::backend_name);

} // namespace
} // namespace paradesc
