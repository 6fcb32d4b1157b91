// Faces that are there twice, and corners that differ by rounding: values are those of the surface without them.
#include <algorithm>
#include <array>
#include <limits>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

class Doubled : public OnBackend {};
PDESC_ON_EACH_BACKEND(Doubled);

// Each of the first faces again, with the same UVs, turned over if asked for.
TestMesh with_copies(TestMesh mesh, bool over, int32_t faces) {
  for (int32_t t = 0; t < faces; ++t)
    for (const int32_t k : over ? std::array{1, 0, 2} : std::array{1, 2, 0}) {
      const auto corner = static_cast<size_t>(3 * t + k);
      mesh.triangle_corners.push_back(static_cast<int32_t>(mesh.corner_vertices.size()));
      mesh.corner_vertices.push_back(mesh.corner_vertices[corner]);
      for (size_t i = 0; i < 2; ++i) mesh.corner_uvs.push_back(mesh.corner_uvs[2 * corner + i]);
      for (size_t i = 0; i < 3; ++i) mesh.corner_normals.push_back(mesh.corner_normals[3 * corner + i]);
    }
  return mesh;
}

const std::vector<std::string> names{"mean_curvature", "gaussian_curvature", "sphere_volume_normalized"};

void expect_same_results(const Results &results, const Results &expected) {
  for (const auto &[name, values] : expected.values) expect_same_bits(std::span(results[name]).first(values.size()), values);
}

TEST_P(Doubled, copies_of_faces_change_no_bit) {
  for (TestMesh mesh :
       {torus(1, 0.4, {.vertices = 1500}), ellipsoid(1, 0.8, 0.6, {.vertices = 1500}), cylinder(0.5, 1, {.vertices = 1500})}) {
    lay_out(mesh, {.charts = 6});
    const Settings settings{.radius = 0.06, .buffer_size = 256};
    const Results alone = compute(context.get(), mesh, settings, names);
    for (const bool over : {false, true})
      for (const int32_t faces : {mesh.triangle_count(), mesh.triangle_count() / 3})
        expect_same_results(compute(context.get(), with_copies(mesh, over, faces), settings, names), alone);
  }
}

// Every triangle has its own vertices, moved by up to so many units in the last place of 1 along each axis.
TestMesh soup_of(const TestMesh &mesh, int units) {
  TestMesh soup = mesh;
  Random random(11);
  soup.vertex_count = static_cast<int32_t>(mesh.corner_vertices.size());
  soup.positions.clear();
  for (size_t corner = 0; corner < mesh.corner_vertices.size(); ++corner) {
    const auto vertex = static_cast<size_t>(mesh.corner_vertices[corner]);
    for (size_t i = 0; i < 3; ++i)
      soup.positions.push_back(mesh.positions[3 * vertex + i] +
                               static_cast<float>(random.uniform(-units, units)) * std::numeric_limits<float>::epsilon());
    soup.corner_vertices[corner] = static_cast<int32_t>(corner);
  }
  return soup;
}

// Positions differ by 4e-7 of a radius at most, and H by their share of the squared edge (0.05): 2e-4 of 1.
TEST_P(Doubled, a_soup_whose_corners_differ_in_the_last_bits_has_the_values_of_its_surface) {
  TestMesh mesh = sphere(1, {.vertices = 2000});
  lay_out(mesh, {.charts = 6});
  const Settings settings{.radius = 0.1, .buffer_size = 256};
  const std::vector<float> expected = compute(context.get(), mesh, settings, names)["mean_curvature"];
  for (const int units : {1, 2}) {
    const std::vector<float> values = compute(context.get(), soup_of(mesh, units), settings, names)["mean_curvature"];
    std::vector<double> at_corners;
    for (const int32_t vertex : mesh.corner_vertices) at_corners.push_back(expected[static_cast<size_t>(vertex)]);
    expect_near(values, at_corners, 2e-4);
  }
}

TEST_P(Doubled, a_back_with_vertices_of_its_own_has_the_values_of_a_surface_turned_over) {
  const TestMesh mesh = cylinder(0.5, 1, {.vertices = 1500});
  TestMesh both = mesh;
  for (const float x : mesh.positions) both.positions.push_back(x);
  both.vertex_count = 2 * mesh.vertex_count;
  for (size_t t = 0; t < mesh.corner_vertices.size(); t += 3)
    for (const size_t k : {1, 0, 2}) {
      both.triangle_corners.push_back(static_cast<int32_t>(both.corner_vertices.size()));
      both.corner_vertices.push_back(mesh.corner_vertices[t + k] + mesh.vertex_count);
    }
  both.corner_normals.clear();
  if (GetParam() == device_backend()) GTEST_SKIP() << "the mesh has no UV map";
  const Settings settings{.radius = 0.06};
  const std::vector<float> values = compute(context.get(), both, settings, names)["mean_curvature"];
  const auto count = static_cast<size_t>(mesh.vertex_count);
  expect_same_bits(std::span(values).first(count), compute(context.get(), mesh, settings, names)["mean_curvature"]);
  for (size_t v = 0; v < count; ++v) EXPECT_NEAR(values[count + v], -values[v], 1e-3) << "vertex " << v; // sums in another order
}

} // namespace
} // namespace paradesc::test
