// Surfels and samples: all of the surface, once, in pieces that are small against the radius.
#include "engine/cpu/surface_samples.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "mesh/extent.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

struct Sampled {
  double area = 0;    // of the mesh, in units of the buffers
  double samples = 0; // of all samples
  int32_t count = 0;
  int32_t surfels = 0, triangles = 0;
  bool each_surfel_has_a_cell = true;
};

Sampled sample(const TestMesh &mesh, double radius) {
  const Triangles triangles = read_triangles(input_of(mesh));
  const HalfEdges half_edges = build_half_edges(triangles);
  const Normals normals =
      compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges), PDESC_NORMALS_FITTED, 1);
  const ClusterTree tree = build_cluster_tree(half_edges);
  const BakeSpace space = bake_space_of(measure_extent(triangles, half_edges, 1).box);
  const SurfelSource source{triangles, half_edges, normals, tree, positions_in(space, triangles, 2), nullptr, 2};
  const auto scaled = static_cast<float>(radius * space.scale);
  const Surfels surfels = build_surfels(source, scaled, 256);
  const SurfaceSamples stored = list_samples(source, surfels);
  SampleList all = stored.list;
  Sampled found;
  for (size_t k = 0; k < surfels.surfel.size(); ++k)
    if (surfels.surfel[k].samples > max_stored_samples)
      divide_triangle(source, surfels, static_cast<int32_t>(k), vec3(0.0f), std::numeric_limits<float>::max(), all);
  for (const FlatSample &one : all.sample) found.samples += static_cast<double>(one.area);
  for (int32_t t = 0; t < triangles.triangle_count; ++t) {
    const vec3 a = source.position(3 * t);
    found.area += 0.5 * static_cast<double>(length(cross(source.position(3 * t + 1) - a, source.position(3 * t + 2) - a)));
    const int32_t cell = surfels.triangle_cell[static_cast<size_t>(t)], surfel = surfels.triangle_surfel[static_cast<size_t>(t)];
    found.each_surfel_has_a_cell &=
        surfel >= surfels.cell_begin[static_cast<size_t>(cell)] && surfel < surfels.cell_begin[static_cast<size_t>(cell) + 1];
  }
  found.count = static_cast<int32_t>(all.sample.size());
  found.surfels = static_cast<int32_t>(surfels.surfel.size());
  found.triangles = triangles.triangle_count;
  return found;
}

TEST(SurfaceSamples, stand_for_all_of_the_surface) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 3000});
  for (const double radius : {0.01, 0.1, 0.4, 1.5}) { // triangles divided and stored, as they are, in clusters
    const Sampled found = sample(mesh, radius);
    EXPECT_NEAR(found.samples, found.area, 1e-5 * found.area) << "radius " << radius;
    EXPECT_TRUE(found.each_surfel_has_a_cell);
  }
}

TEST(SurfaceSamples, are_as_many_as_the_radius_asks_for_however_fine_the_mesh) {
  const double disks = 15.8 / (3.1416 * 0.3 * 0.3); // of the radius, on the torus
  const Sampled coarse = sample(torus(1, 0.4, {.vertices = 800}), 0.3), fine = sample(torus(1, 0.4, {.vertices = 40000}), 0.3);
  // Triangles are cut exactly: fewer of them do than clusters.
  EXPECT_GT(coarse.count, 0.1 * 256 * disks);
  EXPECT_LT(coarse.count, 0.3 * 256 * disks);
  EXPECT_GT(fine.count, 0.4 * 256 * disks);
  EXPECT_LT(fine.count, 1.0 * 256 * disks);
  EXPECT_LT(fine.surfels, 0.5 * fine.triangles) << "clusters of small triangles";
  EXPECT_EQ(coarse.surfels, coarse.triangles);
}

TEST(SurfaceSamples, of_very_large_triangles_are_made_where_they_are_needed) {
  TestMesh mesh = sphere(1, {.vertices = 12});
  const Sampled found = sample(mesh, 0.01);
  EXPECT_NEAR(found.samples, found.area, 1e-3 * found.area) << "a hundred thousand floats";
  EXPECT_GT(found.count, 100000);
}

} // namespace
} // namespace paradesc::test
