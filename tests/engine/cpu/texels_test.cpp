// Evaluation at texels on the engine that has no texture space: what images show, closed forms, what they need and refuse.
#include <algorithm>
#include <cmath>
#include <iostream>

#include "support/api_fixture.h"
#include "support/percent_ae.h"
#include "support/torus_map.h"

namespace paradesc::test {
namespace {

class CpuTexels : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    cpu = open_context(PDESC_BACKEND_CPU, why_not);
    ASSERT_TRUE(cpu) << why_not;
  }

  Field compute_field(pdesc_mesh *mesh, const Settings &settings, const std::vector<const char *> &names) {
    const pdesc_options options = options_of(settings);
    pdesc_field *field = nullptr;
    EXPECT_EQ(pdesc_compute(mesh, &options, names.data(), static_cast<int32_t>(names.size()), nullptr, nullptr, &field), PDESC_OK)
        << pdesc_last_error();
    return Field(field);
  }

  static pdesc_field_report report_of(const pdesc_field *field) {
    pdesc_field_report report;
    pdesc_field_report_init(&report);
    EXPECT_EQ(pdesc_field_get_report(field, &report), PDESC_OK);
    return report;
  }

  // Values at vertices, drawn linearly over the triangles; NaN where no texel's middle lies on one.
  static std::vector<double> image_of(const TestMesh &mesh, const std::vector<double> &values, int32_t size) {
    const std::vector<float> rounded(values.begin(), values.end());
    pdesc_uv_image_input input;
    pdesc_uv_image_input_init(&input);
    input.size = size;
    input.triangle_count = mesh.triangle_count();
    input.value_count = mesh.vertex_count;
    input.components = 1;
    input.uvs = mesh.corner_uvs.data();
    input.triangle_values = mesh.corner_vertices.data();
    input.values = rounded.data();
    std::vector<float> image(static_cast<size_t>(size) * static_cast<size_t>(size), sentinel);
    EXPECT_EQ(pdesc_uv_image_draw(&input, image.data(), static_cast<int64_t>(image.size())), PDESC_OK) << pdesc_last_error();
    return as_double(image);
  }

  // 1 where a texel's middle lies on a triangle.
  static std::vector<uint8_t> covered(const TestMesh &mesh, int32_t size) {
    std::vector<uint8_t> found;
    for (const double one : image_of(mesh, mesh.H, size)) found.push_back(!std::isnan(one));
    return found;
  }

  Context cpu;
};

TEST_F(CpuTexels, of_a_sphere_have_its_curvature_and_so_have_vertices) {
  TestMesh mesh = sphere(2, {.vertices = 2000});
  lay_out(mesh, {.charts = 12});
  const Mesh created = make_mesh(cpu.get(), mesh);
  const Field field = compute_field(created.get(), {.radius = 0.05, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 100},
                                    {"mean_curvature", "principal_direction_min"});
  ASSERT_EQ(pdesc_field_map_size(field.get()), 100);
  const std::vector<float> map = map_of(field.get(), "mean_curvature"), coverage = map_of(field.get(), "coverage"),
                           direction = map_of(field.get(), "principal_direction_min", 3);
  int centers = 0;
  for (size_t i = 0; i < map.size(); ++i) {
    ASSERT_EQ(std::isnan(map[i]), std::isnan(coverage[i]));
    ASSERT_EQ(std::isnan(map[i]), std::isnan(direction[3 * i]));
    if (std::isnan(map[i])) continue;
    ++centers;
    ASSERT_NEAR(map[i], 0.5, 0.01) << "texel " << i << ": 1/R, the mesh is 2000 vertices coarse";
    ASSERT_EQ(coverage[i], 1.0f);
    ASSERT_NEAR(std::hypot(direction[3 * i], direction[3 * i + 1], direction[3 * i + 2]), 1.0, 1e-4);
  }
  const pdesc_field_report report = report_of(field.get());
  EXPECT_EQ(report.places, centers);
  EXPECT_GT(centers, 2000);
  EXPECT_EQ(report.undefined_vertices, 0);
  EXPECT_EQ(report.private_layout, PDESC_LAYOUT_GIVEN);
  std::vector<float> values(static_cast<size_t>(mesh.vertex_count));
  ASSERT_EQ(pdesc_field_values(field.get(), "mean_curvature", values.data(), mesh.vertex_count), PDESC_OK);
  expect_near(values, 0.5, 0.01);
}

// A vertex that lies in the middle of a texel has its own value there, but for the normal, which is rounded anew.
TEST_F(CpuTexels, at_a_vertex_has_the_value_of_the_vertex) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 15});
  const int32_t vertex = mesh.corner_vertices[0];
  const auto middle = [](float x) { return (std::floor(64 * x) + 0.5f) / 64; };
  const float u = mesh.corner_uvs[0], v = mesh.corner_uvs[1];
  for (size_t i = 0; i < mesh.corner_vertices.size(); ++i) // the whole map, so that it stays as it is
    mesh.corner_uvs[2 * i] += middle(u) - u, mesh.corner_uvs[2 * i + 1] += middle(v) - v;
  const Settings at_vertices{.radius = 0.05};
  Settings at_texels = at_vertices;
  at_texels.evaluate = PDESC_EVALUATE_TEXEL;
  at_texels.texels = 64;
  const Mesh created = make_mesh(cpu.get(), mesh);
  const std::vector<const char *> names = {"mean_curvature", "local_bending_energy", "laplacian", "harris"};
  const Field vertices = compute_field(created.get(), at_vertices, names),
              texels = compute_field(created.get(), at_texels, names);
  const auto texel = static_cast<size_t>(64 * middle(v)) * 64 + static_cast<size_t>(64 * middle(u));
  for (const char *name : names) {
    std::vector<float> values(static_cast<size_t>(mesh.vertex_count));
    ASSERT_EQ(pdesc_field_values(vertices.get(), name, values.data(), mesh.vertex_count), PDESC_OK);
    const float expected = values[static_cast<size_t>(vertex)];
    ASSERT_TRUE(std::isfinite(expected));
    EXPECT_NEAR(map_of(texels.get(), name)[texel], expected, 1e-4 * std::abs(expected)) << name;
  }
}

// Operators read the map's value at the texel, which is none of the mesh's points.
TEST_F(CpuTexels, take_operators_on_a_map_whose_closed_form_they_have) {
  TorusMap map = torus_map(1, 0.5, {.vertices = 12000});
  lay_out(map.mesh, {.charts = 15});
  const Mesh created = make_mesh(cpu.get(), map.mesh);
  const Settings settings{.radius = 0.03,
                          .normals = PDESC_NORMALS_MESH,
                          .evaluate = PDESC_EVALUATE_TEXEL,
                          .texels = 256,
                          .map_descriptor = "mean_curvature"};
  const Field field =
      compute_field(created.get(), settings, {"laplacian", "mean_curvature", "gradient_magnitude", "difference_of_gaussians"});
  const auto expect_image = [&](const char *name, const std::vector<double> &exact) {
    const std::vector<float> image = map_of(field.get(), name);
    const PercentAe error = percent_ae(image, image_of(map.mesh, exact, 256), covered(map.mesh, 256));
    std::cout << name << " %AE mean " << error.mean << "\n";
    EXPECT_LE(error.mean, 2) << name << ": as at vertices";
  };
  expect_image("laplacian", map.laplacian);
  expect_image("gradient_magnitude", map.slope);
  expect_image("mean_curvature", map.mesh.H);
  const std::vector<float> curvature = map_of(field.get(), "mean_curvature");
  const std::vector<float> difference = map_of(field.get(), "difference_of_gaussians");
  for (size_t i = 0; i < difference.size(); ++i) ASSERT_EQ(std::isnan(difference[i]), std::isnan(curvature[i])) << i;
}

TEST_F(CpuTexels, need_a_uv_map_and_nothing_else_does) {
  const TestMesh mesh = sphere(1, {.vertices = 400});
  const Mesh created = make_mesh(cpu.get(), mesh);
  const pdesc_options options = options_of({.radius = 0.1, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 16});
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  expect_refused(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_ERROR_INVALID_OPERATION,
                 {"texels", "no UV map", "unwrap", "at vertices"});
  EXPECT_NE(compute_field(created.get(), {.radius = 0.1}, {name}), nullptr);
}

TEST_F(CpuTexels, of_charts_that_share_texture_space_are_laid_out_afresh) {
  TestMesh mesh = sphere(1, {.vertices = 1000});
  lay_out(mesh, {.charts = 6});
  const std::vector<float> apart = mesh.corner_uvs;
  for (size_t i = 0; i < mesh.corner_uvs.size(); i += 2) // one half upon the other: no more than the square's area
    if (mesh.corner_uvs[i] > 0.5f) mesh.corner_uvs[i] -= 0.5f;
  const Mesh created = make_mesh(cpu.get(), mesh);
  const Settings settings{.radius = 0.1, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 128};
  const Field field = compute_field(created.get(), settings, {"mean_curvature"});
  EXPECT_EQ(report_of(field.get()).private_layout, PDESC_LAYOUT_OVERLAPS);
  EXPECT_NE(std::string(pdesc_field_warnings(field.get())).find("laid out afresh"), std::string::npos);
  std::vector<float> layout(mesh.corner_uvs.size()), values(static_cast<size_t>(mesh.vertex_count));
  ASSERT_EQ(pdesc_mesh_layout(created.get(), layout.data(), mesh.triangle_count()), PDESC_OK);
  EXPECT_NE(layout, mesh.corner_uvs);
  ASSERT_EQ(pdesc_field_values(field.get(), "mean_curvature", values.data(), mesh.vertex_count), PDESC_OK);
  expect_near(values, 1.0, 0.02);
  const Field at_vertices = compute_field(created.get(), {.radius = 0.1}, {"mean_curvature"});
  EXPECT_EQ(report_of(at_vertices.get()).private_layout, PDESC_LAYOUT_GIVEN) << "nothing was read of it";
  EXPECT_STREQ(pdesc_field_warnings(at_vertices.get()), "");
  mesh.corner_uvs = apart;
  EXPECT_EQ(report_of(compute_field(make_mesh(cpu.get(), mesh).get(), settings, {"mean_curvature"}).get()).private_layout,
            PDESC_LAYOUT_GIVEN);
}

TEST_F(CpuTexels, of_a_mesh_without_area_in_the_uv_map_are_undefined) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  for (float &coordinate : mesh.corner_uvs) coordinate = 0.5f;
  const Mesh created = make_mesh(cpu.get(), mesh);
  const Field field = compute_field(created.get(), {.radius = 0.1, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 16},
                                    {"principal_direction_min", "laplacian"});
  for (const float value : map_of(field.get(), "principal_direction_min", 3)) ASSERT_TRUE(std::isnan(value)) << value;
  for (const float value : map_of(field.get(), "laplacian")) ASSERT_TRUE(std::isnan(value)) << value;
  std::vector<uint8_t> mask(static_cast<size_t>(mesh.vertex_count));
  ASSERT_EQ(pdesc_field_mask(field.get(), mask.data(), mesh.vertex_count), PDESC_OK);
  EXPECT_EQ(std::count(mask.begin(), mask.end(), PDESC_MASK_NO_TEXEL), mesh.vertex_count);
}

TEST_F(CpuTexels, say_where_the_surface_ends) {
  TestMesh mesh = plane(1, 1, {.vertices = 2000});
  lay_out(mesh, {.charts = 4});
  const Settings settings{.radius = 0.1, .radius_unit = PDESC_RADIUS_ABSOLUTE, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 128};
  const std::string name = "mean_curvature";
  const Results results = compute(cpu.get(), mesh, settings, std::span(&name, 1));
  for (size_t v = 0; v < results.mask.size(); ++v) {
    const double away = mesh.boundary_distance[v];
    if (std::abs(away - 0.1) < 0.05) continue; // a vertex takes the texels around, which lie a hundredth apart
    EXPECT_EQ(results.mask[v], away < 0.1 ? PDESC_MASK_BOUNDARY : 0) << "vertex " << v << ", " << away << " from the boundary";
  }
}

TEST_F(CpuTexels, are_the_same_bits_by_any_number_of_threads) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 15});
  std::vector<std::vector<float>> maps;
  for (const int32_t threads : {1, 3}) {
    pdesc_context_options options;
    pdesc_context_options_init(&options);
    options.backend = PDESC_BACKEND_CPU;
    options.threads = threads;
    pdesc_context *made = nullptr;
    ASSERT_EQ(pdesc_context_create(&options, &made), PDESC_OK);
    const Context context(made);
    const Mesh created = make_mesh(context.get(), mesh);
    const Field field = compute_field(created.get(), {.radius = 0.05, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 600},
                                      {"gaussian_curvature", "harris"}); // more than a band of texels
    maps.push_back(map_of(field.get(), "gaussian_curvature"));
    maps.push_back(map_of(field.get(), "harris"));
  }
  expect_same_bits(maps[0], maps[2]);
  expect_same_bits(maps[1], maps[3]);
}

TEST_F(CpuTexels, that_are_cancelled_leave_the_mesh_usable) {
  TestMesh mesh = sphere(1, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(cpu.get(), mesh);
  const Settings settings{.radius = 0.1, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 512};
  const std::vector<const char *> names = {"mean_curvature", "laplacian"};
  const std::vector<float> expected = map_of(compute_field(created.get(), settings, names).get(), "laplacian");
  const pdesc_options options = options_of(settings);
  double reached = 0;
  const auto stop_halfway = [](void *user, const char *, double fraction) {
    EXPECT_GE(fraction, *static_cast<double *>(user)) << "progress falls";
    *static_cast<double *>(user) = fraction;
    return static_cast<int32_t>(fraction < 0.5);
  };
  pdesc_field *field = nullptr;
  expect_refused(pdesc_compute(created.get(), &options, names.data(), 2, stop_halfway, &reached, &field), PDESC_ERROR_CANCELLED,
                 {});
  EXPECT_LT(reached, 0.95) << "it went on to the end";
  expect_same_bits(map_of(compute_field(created.get(), settings, names).get(), "laplacian"), expected);
}

TEST_F(CpuTexels, are_counted_before_they_are_allocated) {
  TestMesh mesh = sphere(1, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(cpu.get(), mesh);
  const char *name = "mean_curvature";
  const auto host = [&](const Settings &settings) {
    const pdesc_options options = options_of(settings);
    pdesc_memory memory;
    pdesc_memory_init(&memory);
    EXPECT_EQ(pdesc_mesh_memory(created.get(), &options, &name, 1, PDESC_BACKEND_AUTO, &memory), PDESC_OK);
    return memory.host;
  };
  const int64_t vertices = host({.radius = 0.1}), small = host({.radius = 0.1, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 1024}),
                large = host({.radius = 0.1, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 4096});
  EXPECT_GT(small - vertices, 1024 * 1024 * 80);
  EXPECT_GT(large - vertices, 12 * (small - vertices)) << "16 times as many, and a band as before";
}

} // namespace
} // namespace paradesc::test
