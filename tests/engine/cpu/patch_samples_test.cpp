// Samples of triangles and clusters: they stand for all of the surface, once, in pieces that are small against the radius.
#include "engine/cpu/patch_samples.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "engine/cpu/patched_mesh.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr float coherence = 0.9f;

PatchedMesh mesh_of(const TestMesh &mesh, int32_t kind_of_normals = PDESC_NORMALS_FITTED) {
  return PatchedMesh(read_triangles(input_of(mesh)), kind_of_normals);
}
SampleLimit limit_at(const PatchedMesh &mesh, double radius) { return {0.01f * mesh.scaled(radius) * mesh.scaled(radius)}; }

// Returns the patches at this radius, with clusters that are half as large as other samples, or without any.
PointPatches patches_at(const PatchedMesh &mesh, double radius, bool with_clusters) {
  const ClusterLimit limit{0.5f * limit_at(mesh, radius).largest_spread, coherence};
  return mesh.patches(with_clusters ? mesh.nodes(limit) : mesh.single_points());
}

SampledTriangle triangle_of(const PatchedMesh &mesh, int32_t t) {
  SampledTriangle triangle{};
  for (int32_t k = 0; k < 3; ++k) {
    triangle.position[k] = mesh.space.to_buffer(mesh.triangles.position(3 * t + k));
    triangle.normal[k] = mesh.normals.corner(static_cast<size_t>(3 * t + k));
  }
  return triangle;
}

double area_of(const PatchedMesh &mesh) {
  double area = 0;
  for (int32_t t = 0; t < mesh.triangles.triangle_count; ++t) area += static_cast<double>(sample_of(triangle_of(mesh, t)).area);
  return area;
}

double area_of(const SampleList &list) {
  double area = 0;
  for (const FlatSample &sample : list.sample) area += static_cast<double>(sample.area);
  return area;
}

// Both sums of floats are rounded some thousand times, with either sign.
TEST(PatchSamples, stand_for_all_of_the_surface_once) {
  const PatchedMesh mesh = mesh_of(torus(1, 0.4, {.vertices = 3000}));
  for (const double radius : {0.015, 0.1, 0.4, 1.5}) // triangles divided by groups, divided and stored, and undivided ones
    for (const bool with_clusters : {false, true}) {
      const ListedSurface listed(mesh, patches_at(mesh, radius, with_clusters), {.sums = false}, limit_at(mesh, radius),
                                 SampledTriangles::all);
      EXPECT_NEAR(area_of(listed.all_samples()), area_of(mesh), 1e-5 * area_of(mesh)) << "radius " << radius;
      EXPECT_EQ(listed.patches.clusters() > 0, with_clusters && radius > 1.0);
    }
}

// Large triangles and turning ones are listed, and all others and clusters are in the moments of their patches.
TEST(PatchSamples, stand_for_what_has_no_moments) {
  for (const int vertices : {200, 3000}) {
    const PatchedMesh mesh = mesh_of(torus(1, 0.4, {.vertices = vertices}));
    const double radius = vertices == 200 ? 0.2 : 1.5;
    const ListedSurface listed(mesh, patches_at(mesh, radius, true), {.large = 1.25f * mesh.scaled(radius)},
                               limit_at(mesh, radius), SampledTriangles::large);
    const PatchArrays &arrays = listed.surface.arrays();
    double area = 0;
    for (int32_t patch = 0; patch < arrays.patches; ++patch)
      area += static_cast<double>(arrays.moment[arrays.row_of_patch(patch)].of[moment_area]);
    listed.for_each_item([&](const SampleBlock &block, int32_t k) {
      for (int32_t i = block.first[k]; block.item[k] >= 0 && i < block.first[k + 1]; ++i)
        area += static_cast<double>(block.list.sample[i].area);
    });
    EXPECT_NEAR(area, area_of(mesh), 1e-5 * area_of(mesh)) << vertices << " vertices";
    if (vertices == 200) {
      EXPECT_GT(listed.items(), 20u);
    } else {
      EXPECT_EQ(listed.items(), static_cast<size_t>(listed.patches.clusters()));
    }
  }
}

// Triangles of coarse meshes are halved until their parts are small enough, so that the number is rounded to powers of two.
TEST(PatchSamples, are_about_as_many_as_were_counted_and_few_where_they_are_clusters) {
  const double radius = 0.6;
  for (const int vertices : {800, 3000, 40000}) {
    const PatchedMesh mesh = mesh_of(torus(1, 0.4, {.vertices = vertices}));
    const ListedSurface listed(mesh, patches_at(mesh, radius, true), {.sums = false}, limit_at(mesh, radius),
                               SampledTriangles::all);
    const auto samples = static_cast<double>(listed.stored_samples());
    const double counted = count_samples(listed.sampled, listed.limit, SampledTriangles::all);
    EXPECT_NEAR(samples / counted, 1.0, 0.15) << vertices << " vertices";
    if (vertices < 40000) continue;
    EXPECT_LT(listed.stored_samples(), static_cast<size_t>(mesh.triangles.triangle_count / 4));
    EXPECT_GT(listed.patches.clusters(), 1000);
  }
}

TestMesh needles(float tip, float height, bool turn) {
  TestMesh mesh;
  mesh.vertex_count = 24;
  for (int k = 0; k < 8; ++k) {
    const float y = 0.05f * static_cast<float>(k);
    for (const vec3 position : {vec3(0, y, 0), vec3(1, y, 0), vec3(tip, y + height, 0)})
      mesh.positions.insert(mesh.positions.end(), {position.x, position.y, position.z});
    for (int corner = 0; corner < 3; ++corner) {
      if (turn) mesh.corner_normals.insert(mesh.corner_normals.end(), {0.0f, 0.0f, corner == 2 ? -1.0f : 1.0f});
      mesh.corner_vertices.push_back(3 * k + corner);
      mesh.triangle_corners.push_back(3 * k + corner);
    }
  }
  return mesh;
}

// Halved at their longest edges they would come to hundreds of pieces side by side.
TEST(PatchSamples, of_needles_are_as_many_as_lie_in_a_row) {
  for (const float tip : {0.0f, 0.1f, 0.5f, 1.0f}) { // the place of the third corner along the longest edge
    const PatchedMesh mesh = mesh_of(needles(tip, 1e-5f, false));
    const SampleLimit limit = limit_at(mesh, 0.002);
    const float length_of_sample = std::sqrt(18.0f * limit.largest_spread) / static_cast<float>(mesh.space.scale); // at most
    for (int32_t t = 0; t < 8; ++t) {
      SampleList divided;
      divide_triangle(triangle_of(mesh, t), limit, {}, false, divided);
      EXPECT_NEAR(area_of(divided), sample_of(triangle_of(mesh, t)).area, 1e-3 * area_of(divided)) << "differences of floats";
      EXPECT_LT(static_cast<float>(divided.sample.size()), 8.0f / length_of_sample) << "third corner at " << tip;
      EXPECT_GT(static_cast<float>(divided.sample.size()), 1.0f / length_of_sample) << "third corner at " << tip;
    }
  }
}

// They turn by half a circle from the longest edge to the third corner, on however short pieces. The count sets how much
// memory is allowed, and how much of a triangle is kept. Pieces of needles are halved until they fit, two of them side by
// side.
TEST(PatchSamples, of_slivers_whose_normals_turn_across_them_are_about_as_many_as_were_counted) {
  for (const float height : {1e-4f, 1e-3f, 1e-2f}) {
    const PatchedMesh mesh = mesh_of(needles(0.5f, height, true), PDESC_NORMALS_MESH);
    const SampleLimit limit = limit_at(mesh, 0.02);
    for (int32_t t = 0; t < 8; ++t) {
      SampleList divided;
      divide_triangle(triangle_of(mesh, t), limit, {}, false, divided);
      const auto count = static_cast<float>(divided.sample.size());
      const float counted = count_samples(triangle_of(mesh, t), limit).samples;
      EXPECT_LT(count, 8.0f * counted) << "height " << height;
      EXPECT_GT(count, 0.25f * counted) << "height " << height;
    }
  }
}

// Normals lie linearly between those of a triangle's corners before they get their length, and not between those of its parts.
TEST(PatchSamples, of_parts_have_the_normals_of_the_whole) {
  const PatchedMesh mesh = mesh_of(sphere(1, {.vertices = 12}));
  const SampleLimit limit = limit_at(mesh, 0.5);
  for (int32_t t = 0; t < mesh.triangles.triangle_count; ++t) {
    const SampledTriangle triangle = triangle_of(mesh, t);
    SampleList divided;
    divide_triangle(triangle, limit, {}, false, divided);
    ASSERT_GT(divided.sample.size(), 10u);
    vec3 found(0.0f), mean(0.0f);
    for (const FlatSample &one : divided.sample) found += one.area * vec3(one.normal[0], one.normal[1], one.normal[2]);
    constexpr int parts = 100;
    for (int i = 0; i < parts; ++i)
      for (int k = 0; k < parts; ++k) {
        const float first = (static_cast<float>(i) + 0.5f) / parts, second = (static_cast<float>(k) + 0.5f) / parts;
        const bool beyond = first + second > 1.0f;
        const float u = beyond ? 1.0f - first : first, v = beyond ? 1.0f - second : second;
        mean += glm::normalize((1.0f - u - v) * triangle.normal[0] + u * triangle.normal[1] + v * triangle.normal[2]);
      }
    const vec3 expected = sample_of(triangle).area / (parts * parts) * mean;
    EXPECT_LT(length(found - expected), 1e-4f * length(expected)) << "triangle " << t;
  }
}

void expect_linear_map(const ListedSurface &listed, vec3 slope) {
  const SampleList all = listed.all_samples();
  ASSERT_EQ(all.map.size(), all.sample.size());
  const auto vector = [](const float *v) { return vec3(v[0], v[1], v[2]); };
  for (size_t i = 0; i < all.sample.size(); ++i) {
    const FlatSample &one = all.sample[i];
    const float spread =
        std::sqrt(dot(vector(one.along[0]), vector(one.along[0])) + dot(vector(one.along[1]), vector(one.along[1])));
    const float limit = one.is_cluster > 0.0f ? 0.1f * spread : 1e-6f;
    const auto expect_near = [&](const float *found, vec3 position) {
      EXPECT_NEAR(length(vector(found) - position), 0.0f, limit) << i;
      EXPECT_NEAR(found[3], dot(slope, position), 3.0f * limit) << i;
    };
    expect_near(all.map[i].mean, vector(one.position));
    for (size_t k = 0; k < 2; ++k) expect_near(all.map[i].along[k], vector(one.along[k]));
  }
}

// The map's gradient is the position, and its value is linear in it. Samples of triangles have it exactly, and clusters but for
// how they leave their planes.
TEST(PatchSamples, know_how_a_map_varies_on_them) {
  const PatchedMesh mesh = mesh_of(torus(1, 0.4, {.vertices = 3000}));
  const vec3 slope(1.0f, -2.0f, 0.5f);
  MapValues map;
  for (const vec3 position : mesh.positions()) map.emplace_back(position, dot(slope, position));
  for (const double radius : {0.05, 0.2, 1.5}) { // divided, as they are, in clusters
    const ListedSurface listed(mesh, patches_at(mesh, radius, true), {.sums = false}, limit_at(mesh, radius),
                               SampledTriangles::all, ball_targets()[0], 2, &map);
    EXPECT_EQ(listed.patches.clusters() > 0, radius > 1.0);
    expect_linear_map(listed, slope);
  }
}

} // namespace
} // namespace paradesc::test
