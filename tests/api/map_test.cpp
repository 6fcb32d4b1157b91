// Evaluation at texels, precision of the buffers, maps and buffers through the C interface on the software device.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>

#include "support/api_fixture.h"
#include "support/percent_ae.h"

namespace paradesc::test {
namespace {

class Maps : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    software = open_context(device_backend(), why_not);
    if (!software) GTEST_SKIP() << why_not;
    reference = open_context(PDESC_BACKEND_REFERENCE, why_not);
    ASSERT_TRUE(reference);
  }

  Field compute_field(pdesc_mesh *mesh, const Settings &settings, const char *name = "mean_curvature") {
    const pdesc_options options = options_of(settings);
    pdesc_field *field = nullptr;
    EXPECT_EQ(pdesc_compute(mesh, &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
    return Field(field);
  }

  static std::vector<float> at_vertices(const pdesc_field *field, int32_t vertex_count) {
    std::vector<float> values(static_cast<size_t>(vertex_count), sentinel);
    EXPECT_EQ(pdesc_field_values(field, "mean_curvature", values.data(), vertex_count), PDESC_OK) << pdesc_last_error();
    return values;
  }

  // Mean %AE of curvatures in 16 bits against those in 32.
  void expect_half_within_a_tenth(TestMesh mesh) {
    lay_out(mesh, {.charts = 12});
    const std::vector<std::string> names = {"mean_curvature", "gaussian_curvature", "principal_curvature_max", "curvedness"};
    Settings settings{.radius = 0.03};
    const Results oracle = compute(reference.get(), mesh, settings, names);
    const Results full = compute(software.get(), mesh, settings, names);
    settings.precision = PDESC_PRECISION_HALF;
    const Results half = compute(software.get(), mesh, settings, names);
    for (const std::string &name : names) {
      const std::vector<double> expected = as_double(oracle[name]);
      const double error = percent_ae(full[name], expected).mean, with_half = percent_ae(half[name], expected).mean;
      std::cout << std::left << std::setw(26) << name << " %AE full " << error << "  half " << with_half << "\n";
      EXPECT_LE(with_half, 1.1 * error) << name;
    }
    EXPECT_DOUBLE_EQ(full.report.buffer_megabytes, 48e-6 * 1024 * 1024);
    EXPECT_DOUBLE_EQ(half.report.buffer_megabytes, 32e-6 * 1024 * 1024);
  }

  Context software, reference;
};

TEST_F(Maps, half_is_within_a_tenth_of_full_on_a_torus) { expect_half_within_a_tenth(torus(1.0, 0.4, {.vertices = 5000})); }

TEST_F(Maps, half_is_within_a_tenth_of_full_on_an_ellipsoid) {
  expect_half_within_a_tenth(ellipsoid(1.0, 0.8, 0.6, {.vertices = 5000}));
}

TEST_F(Maps, a_change_of_precision_bakes_anew) {
  TestMesh mesh = sphere(1, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(software.get(), mesh);
  std::vector<std::vector<float>> values;
  for (const int32_t precision : {PDESC_PRECISION_FULL, PDESC_PRECISION_HALF, PDESC_PRECISION_FULL}) {
    const Field field = compute_field(created.get(), {.radius = 0.1, .buffer_size = 256, .precision = precision});
    values.emplace_back(at_vertices(field.get(), mesh.vertex_count));
  }
  expect_same_bits(values[0], values[2]);
  EXPECT_NE(values[0], values[1]);
}

// With charts turned, mirrored and of different scales.
TEST_F(Maps, texels_of_a_sphere_have_its_curvature_and_so_have_vertices) {
  TestMesh mesh = sphere(2, {.vertices = 2000});
  lay_out(mesh, {.charts = 12});
  const Mesh created = make_mesh(software.get(), mesh);
  const Field field =
      compute_field(created.get(), {.radius = 0.05, .buffer_size = 512, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 100});
  ASSERT_EQ(pdesc_field_map_size(field.get()), 100);
  const std::vector<float> map = map_of(field.get(), "mean_curvature"), coverage = map_of(field.get(), "coverage"),
                           boundary = map_of(field.get(), "boundary");
  int centers = 0;
  for (size_t i = 0; i < map.size(); ++i) {
    ASSERT_EQ(std::isnan(map[i]), std::isnan(coverage[i]));
    ASSERT_EQ(std::isnan(map[i]), std::isnan(boundary[i]));
    if (std::isnan(map[i])) continue;
    ASSERT_EQ(boundary[i], 0.0f) << "the sphere is closed";
    ++centers;
    // 1/R; the mesh is 2000 vertices coarse, and samples leave gaps and overlaps where seams bend.
    ASSERT_NEAR(map[i], 0.5, 0.05) << "texel " << i;
  }
  pdesc_field_report report;
  pdesc_field_report_init(&report);
  ASSERT_EQ(pdesc_field_get_report(field.get(), &report), PDESC_OK);
  EXPECT_EQ(report.places, centers);
  EXPECT_GT(centers, 2000);
  EXPECT_EQ(report.undefined_vertices, 0);
  for (const float value : at_vertices(field.get(), mesh.vertex_count)) ASSERT_NEAR(value, 0.5, 0.05);
}

TEST_F(Maps, texels_looked_up_at_vertices_agree_with_the_reference) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 4000});
  lay_out(mesh, {.charts = 15});
  const std::vector<std::string> names = {"mean_curvature", "gaussian_curvature", "principal_direction_max"};
  Settings settings{.radius = 0.05, .samples = 64};
  const Results oracle = compute(reference.get(), mesh, settings, names);
  settings.evaluate = PDESC_EVALUATE_TEXEL;
  settings.texels = 256;
  const Results found = compute(software.get(), mesh, settings, names);
  for (const char *name : {"mean_curvature", "gaussian_curvature"}) {
    const double error = percent_ae(found[name], as_double(oracle[name])).mean;
    std::cout << name << " %AE " << error << "\n";
    // A texel is a hundredth of the range apart from the next; at borders the nearest texels stand for the vertex.
    EXPECT_LE(error, 1.0) << name;
  }
  double turned = 0;
  for (size_t v = 0; v < static_cast<size_t>(mesh.vertex_count); ++v) {
    const float *a = &found["principal_direction_max"][3 * v], *b = &oracle["principal_direction_max"][3 * v];
    turned += 1 - std::abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
  }
  EXPECT_LE(turned / mesh.vertex_count, 1e-3) << "the mean of 1 - cos; 2.6 degrees";
}

TEST_F(Maps, a_cancelled_evaluation_at_texels_leaves_the_mesh_usable) {
  TestMesh mesh = sphere(1, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(software.get(), mesh);
  const Settings settings{.radius = 0.1, .buffer_size = 256, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 512};
  const std::vector<float> expected = at_vertices(compute_field(created.get(), settings).get(), mesh.vertex_count);
  const pdesc_options options = options_of(settings);
  const char *name = "mean_curvature";
  double reached = 0;
  const auto stop_halfway = [](void *user, const char *, double fraction) {
    EXPECT_GE(fraction, *static_cast<double *>(user)) << "progress falls";
    *static_cast<double *>(user) = fraction;
    return static_cast<int32_t>(fraction < 0.7);
  };
  pdesc_field *field = nullptr;
  expect_refused(pdesc_compute(created.get(), &options, &name, 1, stop_halfway, &reached, &field), PDESC_ERROR_CANCELLED, {});
  EXPECT_LT(reached, 0.95) << "it went on to the end";
  expect_same_bits(at_vertices(compute_field(created.get(), settings).get(), mesh.vertex_count), expected);
}

TEST_F(Maps, a_map_of_a_direction_has_three_components) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 800});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(software.get(), mesh);
  const Settings settings{.radius = 0.1, .buffer_size = 256, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 32};
  const Field field = compute_field(created.get(), settings, "principal_direction_min");
  int seen = 0;
  const std::vector<float> map = map_of(field.get(), "principal_direction_min", 3);
  for (size_t i = 0; i < map.size(); i += 3) {
    if (std::isnan(map[i])) continue;
    ASSERT_NEAR(std::hypot(map[i], map[i + 1], map[i + 2]), 1.0, 1e-4);
    ++seen;
  }
  EXPECT_GT(seen, 300);
}

// A map without centers has no result to draw: names were read beyond the maps.
TEST_F(Maps, a_mesh_without_area_in_the_uv_map_has_maps_of_undefined_texels) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  for (float &coordinate : mesh.corner_uvs) coordinate = 0.5f;
  const Mesh created = make_mesh(software.get(), mesh);
  const Settings settings{.radius = 0.1, .buffer_size = 64, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 16};
  const Field field = compute_field(created.get(), settings, "principal_direction_min");
  for (const float value : map_of(field.get(), "principal_direction_min", 3)) ASSERT_TRUE(std::isnan(value)) << value;
  for (const float value : map_of(field.get(), "coverage")) ASSERT_TRUE(std::isnan(value)) << value;
}

// Operators read their map between vertices there, too.
TEST_F(Maps, operators_at_texels_agree_with_the_reference) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 4000});
  lay_out(mesh, {.charts = 15});
  const std::vector<std::string> names = {"gradient_magnitude"};
  Settings settings{.radius = 0.1, .samples = 64};
  const Results oracle = compute(reference.get(), mesh, settings, names);
  settings.evaluate = PDESC_EVALUATE_TEXEL;
  settings.texels = 128;
  const Results found = compute(software.get(), mesh, settings, names);
  const double error = percent_ae(found[names[0]], as_double(oracle[names[0]])).mean;
  std::cout << "gradient_magnitude %AE " << error << "\n";
  EXPECT_LE(error, 2.0) << "samples are few, and a texel is a fiftieth of the range apart from the next";
}

TEST_F(Maps, displacement_is_refused_at_texels) {
  TestMesh mesh = sphere(1, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(software.get(), mesh);
  const pdesc_options options = options_of({.radius = 0.1, .buffer_size = 64, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 16});
  pdesc_field *field = nullptr;
  const char *name = "mean_curvature";
  const float height = 0.5f;
  ASSERT_EQ(pdesc_mesh_set_displacement(created.get(), &height, 1, 1, 0, 1), PDESC_OK) << pdesc_last_error();
  expect_refused(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_ERROR_INVALID_ARGUMENT,
                 {"isplacement", "at vertices"});
  ASSERT_EQ(pdesc_mesh_set_displacement(created.get(), nullptr, 0, 0, 0, 1), PDESC_OK) << pdesc_last_error();
  EXPECT_NE(compute_field(created.get(), {.radius = 0.1, .buffer_size = 64, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 16}),
            nullptr);
}

TEST_F(Maps, what_is_not_there_is_refused) {
  TestMesh mesh = sphere(1, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(software.get(), mesh);
  std::vector<float> values(16, sentinel);
  EXPECT_EQ(pdesc_mesh_buffer_size(created.get()), 0);
  expect_refused(pdesc_mesh_read_buffer(created.get(), "chart", values.data(), 16), PDESC_ERROR_INVALID_OPERATION, {"compute"});
  Settings settings{.radius = 0.1, .buffer_size = 64};
  const Field of_vertices = compute_field(created.get(), settings);
  EXPECT_EQ(pdesc_field_map_size(of_vertices.get()), 0);
  expect_refused(pdesc_field_map(of_vertices.get(), "mean_curvature", values.data(), 16), PDESC_ERROR_INVALID_OPERATION,
                 {"TEXEL"});
  settings.evaluate = PDESC_EVALUATE_TEXEL;
  settings.texels = 16;
  const Field at_texels = compute_field(created.get(), settings);
  expect_refused(pdesc_field_map(at_texels.get(), "mean_curvature", values.data(), 16), PDESC_ERROR_INVALID_ARGUMENT,
                 {"16", "256"});
  expect_refused(pdesc_field_map(at_texels.get(), "curvedness", values.data(), 256), PDESC_ERROR_INVALID_ARGUMENT,
                 {"curvedness"});
  expect_refused(pdesc_mesh_read_buffer(created.get(), "colour", values.data(), 16), PDESC_ERROR_INVALID_ARGUMENT, {"colour"});
  expect_refused(pdesc_mesh_read_buffer(created.get(), "chart", values.data(), 16), PDESC_ERROR_INVALID_ARGUMENT, {"4096"});
  expect_refused(pdesc_mesh_layout(created.get(), values.data(), 7), PDESC_ERROR_INVALID_ARGUMENT, {"7"});
  EXPECT_EQ(values, std::vector<float>(16, sentinel)) << "output was touched on failure";
}

TEST_F(Maps, buffers_hold_the_surface_in_units_of_the_positions) {
  TestMesh mesh = sphere(3, {.vertices = 3000});
  for (float &x : mesh.positions) x += 10.0f;
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(software.get(), mesh);
  (void)compute_field(created.get(), {.radius = 0.1, .buffer_size = 128});
  ASSERT_EQ(pdesc_mesh_buffer_size(created.get()), 128);
  const auto read = [&](const char *name, size_t components) {
    std::vector<float> values(128 * 128 * components, sentinel);
    EXPECT_EQ(pdesc_mesh_read_buffer(created.get(), name, values.data(), static_cast<int64_t>(values.size())), PDESC_OK)
        << pdesc_last_error();
    EXPECT_EQ(std::count(values.begin(), values.end(), sentinel), 0);
    return values;
  };
  const auto position = read("position", 3), normal = read("normal", 3), distortion = read("distortion", 4),
             chart = read("chart", 1), neighbor = read("neighbor", 1);
  double area = 0;
  int seams = 0;
  for (size_t i = 0; i < chart.size(); ++i) {
    ASSERT_EQ(chart[i] < 0, std::isnan(position[3 * i]));
    if (chart[i] < 0) {
      EXPECT_EQ(neighbor[i], -1.0f);
      continue;
    }
    const Vec3 p{position[3 * i] - 10, position[3 * i + 1] - 10, position[3 * i + 2] - 10};
    const Vec3 n{normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]};
    ASSERT_NEAR(length(p), 3, 0.03) << "facets of 3000 vertices";
    ASSERT_GT(dot(n, p), 2.9);
    ASSERT_NEAR(distortion[4 * i] * distortion[4 * i + 1], distortion[4 * i + 3], 1e-3 * distortion[4 * i + 3]);
    area += static_cast<double>(distortion[4 * i + 3]) / (128.0 * 128.0);
    if (neighbor[i] < 0) continue;
    ++seams;
    EXPECT_LT(neighbor[i], 6.0f);
    EXPECT_NE(neighbor[i], chart[i]) << "six faces of a cube have no seam with themselves";
  }
  EXPECT_GT(seams, 200);
  // 4 pi R^2, and half a texel beyond every border.
  EXPECT_NEAR(area, 36 * std::acos(-1.0), 0.15 * 113);
  std::vector<float> layout(mesh.corner_uvs.size(), sentinel);
  ASSERT_EQ(pdesc_mesh_layout(created.get(), layout.data(), mesh.triangle_count()), PDESC_OK);
  expect_same_bits(layout, mesh.corner_uvs);
}

} // namespace
} // namespace paradesc::test
