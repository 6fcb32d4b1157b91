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

// What samples are made of.
struct Prepared {
  explicit Prepared(const TestMesh &mesh, int32_t kind_of_normals = PDESC_NORMALS_FITTED)
      : triangles(read_triangles(input_of(mesh))), half_edges(build_half_edges(triangles)),
        normals(compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges), kind_of_normals, 1)),
        tree(build_cluster_tree(half_edges)), space(bake_space_of(measure_extent(triangles, half_edges, 1).box)),
        source{triangles, half_edges, normals, tree, positions_in(space, triangles, 2), nullptr, 2, static_cast<float>(space.scale)} {}
  Triangles triangles;
  HalfEdges half_edges;
  Normals normals;
  ClusterTree tree;
  BakeSpace space;
  SurfelSource source;
};

Sampled sample(const TestMesh &mesh, double radius) {
  const Prepared prepared(mesh);
  const auto &[triangles, half_edges, normals, tree, space, source] = prepared;
  const auto scaled = static_cast<float>(radius * space.scale);
  const Surfels surfels = build_surfels(source, scaled, {256});
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
  // Triangles are cut exactly, so that fewer of them do than clusters; but those on which normals turn are divided more.
  EXPECT_GT(coarse.count, 0.15 * 256 * disks);
  EXPECT_LT(coarse.count, 0.6 * 256 * disks);
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

// Halved at their longest edges they would come to hundreds of pieces side by side.
TEST(SurfaceSamples, of_needles_are_as_many_as_lie_in_a_row) {
  for (const float tip : {0.0f, 0.1f, 0.5f, 1.0f}) { // where the third corner is along the longest edge
    TestMesh mesh;
    mesh.vertex_count = 24;
    for (int k = 0; k < 8; ++k) {
      const float y = 0.05f * static_cast<float>(k);
      for (const vec3 position : {vec3(0, y, 0), vec3(1, y, 0), vec3(tip, y + 1e-5f, 0)})
        mesh.positions.insert(mesh.positions.end(), {position.x, position.y, position.z});
      for (int corner = 0; corner < 3; ++corner) {
        mesh.corner_vertices.push_back(3 * k + corner);
        mesh.triangle_corners.push_back(3 * k + corner);
      }
    }
    const double radius = 0.002;
    const Sampled found = sample(mesh, radius);
    EXPECT_NEAR(found.samples, found.area, 1e-3 * found.area);
    const double across_a_sample = 4 * radius / std::sqrt(256.0); // about
    EXPECT_LT(found.count, 8 * 8 / across_a_sample) << "third corner at " << tip;
    EXPECT_GT(found.count, 8 / across_a_sample);
  }
}

// They turn by half a circle from the longest edge to the third corner, on however short pieces: what is counted on is what
// memory is allowed for, and how much of a triangle is kept. Pieces of needles are halved until they fit, two of them side by
// side.
TEST(SurfaceSamples, of_slivers_whose_normals_turn_across_them_are_about_as_many_as_were_counted) {
  for (const float height : {1e-4f, 1e-3f, 1e-2f}) {
    TestMesh mesh;
    mesh.vertex_count = 24;
    for (int k = 0; k < 8; ++k) {
      const float y = 0.05f * static_cast<float>(k);
      for (const vec3 position : {vec3(0, y, 0), vec3(1, y, 0), vec3(0.5f, y + height, 0)})
        mesh.positions.insert(mesh.positions.end(), {position.x, position.y, position.z});
      for (int corner = 0; corner < 3; ++corner) {
        mesh.corner_normals.insert(mesh.corner_normals.end(), {0.0f, 0.0f, corner == 2 ? -1.0f : 1.0f});
        mesh.corner_vertices.push_back(3 * k + corner);
        mesh.triangle_corners.push_back(3 * k + corner);
      }
    }
    const Prepared prepared(mesh, PDESC_NORMALS_MESH);
    const Surfels surfels = build_surfels(prepared.source, static_cast<float>(0.02 * prepared.space.scale), {256});
    for (size_t k = 0; k < surfels.surfel.size(); ++k) {
      SampleList divided;
      divide_triangle(prepared.source, surfels, static_cast<int32_t>(k), vec3(0.0f), std::numeric_limits<float>::max(), divided);
      const auto count = static_cast<float>(divided.sample.size());
      EXPECT_LT(count, 8.0f * surfels.surfel[k].samples) << "height " << height;
      EXPECT_GT(count, 0.25f * surfels.surfel[k].samples) << "height " << height;
    }
  }
}

// Normals lie linearly between those of a triangle's corners before they get their length, and not between those of its parts.
TEST(SurfaceSamples, of_parts_have_the_normals_of_the_whole) {
  const Prepared prepared(sphere(1, {.vertices = 12}));
  const SurfelSource &source = prepared.source;
  const Surfels surfels = build_surfels(source, static_cast<float>(1.0 * prepared.space.scale), {256});
  std::vector<vec3> found(surfels.surfel.size(), vec3(0.0f));
  for (const FlatSample &one : list_samples(source, surfels).list.sample)
    found[static_cast<size_t>(one.surfel)] += one.area * vec3(one.normal[0], one.normal[1], one.normal[2]);
  for (int32_t t = 0; t < prepared.triangles.triangle_count; ++t) {
    const vec3 a = source.position(3 * t), b = source.position(3 * t + 1), c = source.position(3 * t + 2);
    const auto normal = [&](int32_t k) { return source.normals.corner(static_cast<size_t>(3 * t + k)); };
    constexpr int parts = 100;
    vec3 mean(0.0f);
    for (int i = 0; i < parts; ++i)
      for (int k = 0; k < parts; ++k) {
        const float first = (static_cast<float>(i) + 0.5f) / parts, second = (static_cast<float>(k) + 0.5f) / parts;
        const bool beyond = first + second > 1.0f;
        const float u = beyond ? 1.0f - first : first, v = beyond ? 1.0f - second : second;
        mean += glm::normalize((1.0f - u - v) * normal(0) + u * normal(1) + v * normal(2));
      }
    const vec3 expected = 0.5f * length(cross(b - a, c - a)) / (parts * parts) * mean;
    const vec3 gap = found[static_cast<size_t>(surfels.triangle_surfel[static_cast<size_t>(t)])] - expected;
    EXPECT_LT(length(gap), 1e-4f * length(expected)) << "triangle " << t;
  }
}

// A map whose gradient is the position, and whose value is linear in it: samples of triangles have it exactly, clusters but for
// how they leave their planes.
TEST(SurfaceSamples, know_how_a_map_varies_on_them) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 3000});
  for (const double radius : {0.05, 0.2, 1.5}) { // divided, as they are, in clusters
    Prepared prepared(mesh);
    const vec3 slope(1.0f, -2.0f, 0.5f);
    std::vector<vec4> map;
    for (const int32_t vertex : prepared.half_edges.point_vertex) {
      const vec3 position = prepared.source.positions[static_cast<size_t>(vertex)];
      map.emplace_back(position, dot(slope, position));
    }
    prepared.source.map = &map;
    const Surfels surfels = build_surfels(prepared.source, static_cast<float>(radius * prepared.space.scale), {256});
    SampleList all = list_samples(prepared.source, surfels).list;
    for (size_t k = 0; k < surfels.surfel.size(); ++k)
      if (surfels.surfel[k].samples > max_stored_samples)
        divide_triangle(prepared.source, surfels, static_cast<int32_t>(k), vec3(0.0f), std::numeric_limits<float>::max(), all);
    ASSERT_EQ(all.map.size(), all.sample.size());
    const auto vector = [](const float *v) { return vec3(v[0], v[1], v[2]); };
    for (size_t i = 0; i < all.sample.size(); ++i) {
      const FlatSample &one = all.sample[i];
      const bool is_cluster = surfels.surfel[static_cast<size_t>(one.surfel)].cluster >= 0;
      const float limit = is_cluster ? 0.1f * one.reach : 1e-6f;
      const auto expect_near = [&](const float *found, vec3 position) {
        EXPECT_NEAR(length(vector(found) - position), 0.0f, limit) << i << " at radius " << radius;
        EXPECT_NEAR(found[3], dot(slope, position), 3.0f * limit) << i << " at radius " << radius;
      };
      expect_near(all.map[i].mean, vector(one.position));
      for (size_t k = 0; k < 2; ++k) expect_near(all.map[i].along[k], vector(one.along[k]));
    }
  }
}

} // namespace
} // namespace paradesc::test
