// Images of the engine on the CPU against those of texture space: the same texels, the same values.
#include <cmath>
#include <iostream>

#include "support/api_fixture.h"
#include "support/percent_ae.h"

namespace paradesc::test {
namespace {

class TexelParity : public ::testing::Test {
protected:
  void SetUp() override {
    std::string why_not;
    software = open_context(device_backend(), why_not);
    if (!software) GTEST_SKIP() << why_not;
    cpu = open_context(PDESC_BACKEND_CPU, why_not);
    reference = open_context(PDESC_BACKEND_REFERENCE, why_not);
    ASSERT_TRUE(cpu && reference);
  }

  static constexpr const char *names[] = {"mean_curvature", "gaussian_curvature", "curvedness", "sphere_volume_normalized"};

  struct Maps {
    std::vector<std::vector<float>> values; // of each name, then of the coverage
    std::vector<float> layout;
  };

  static Maps maps_of(pdesc_context *context, const TestMesh &mesh, const Settings &settings) {
    const Mesh created = make_mesh(context, mesh);
    const pdesc_options options = options_of(settings);
    pdesc_field *field = nullptr;
    EXPECT_EQ(pdesc_compute(created.get(), &options, names, 4, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
    const Field owner(field);
    Maps maps;
    const auto size = static_cast<size_t>(pdesc_field_map_size(field));
    EXPECT_EQ(size, static_cast<size_t>(settings.texels));
    for (const char *name : {names[0], names[1], names[2], names[3], "coverage"}) {
      std::vector<float> &values = maps.values.emplace_back(size * size, sentinel);
      EXPECT_EQ(pdesc_field_map(field, name, values.data(), static_cast<int64_t>(values.size())), PDESC_OK) << pdesc_last_error();
    }
    maps.layout.resize(mesh.corner_uvs.size());
    EXPECT_EQ(pdesc_mesh_layout(created.get(), maps.layout.data(), mesh.triangle_count()), PDESC_OK);
    return maps;
  }

  // The same texels have values, and these differ by no more than two backends may (PDESC_PARITY_PERCENT).
  void expect_parity(const TestMesh &mesh, const Settings &settings) {
    const Maps device = maps_of(software.get(), mesh, settings), ours = maps_of(cpu.get(), mesh, settings);
    ASSERT_EQ(ours.layout, device.layout);
    for (size_t i = 0; i < ours.values[4].size(); ++i) ASSERT_EQ(std::isnan(ours.values[4][i]), std::isnan(device.values[4][i]));
    for (size_t k = 0; k < 4; ++k) {
      const double error = percent_ae(ours.values[k], as_double(device.values[k])).mean;
      std::cout << names[k] << " %AE between images " << error << "\n";
      EXPECT_LE(error, PDESC_PARITY_PERCENT) << names[k];
    }
    const std::vector<std::string> all(std::begin(names), std::end(names));
    Settings at_vertices = settings;
    at_vertices.evaluate = PDESC_EVALUATE_VERTEX;
    const Results oracle = compute(reference.get(), mesh, at_vertices, all), found = compute(cpu.get(), mesh, settings, all);
    for (const std::string &name : std::span(all).first(3)) { // the middle of a face lies lower than vertices, in another volume
      const double error = percent_ae(found[name], as_double(oracle[name])).mean;
      std::cout << name << " %AE of vertices looked up " << error << "\n";
      EXPECT_LE(error, 1.0) << name << ": what lookups in texels add is most of it";
    }
  }

  Context software, cpu, reference;
};

TEST_F(TexelParity, on_a_torus) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 4000});
  lay_out(mesh, {.charts = 15});
  expect_parity(mesh, {.radius = 0.05, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 256});
}

TEST_F(TexelParity, on_an_ellipsoid) {
  TestMesh mesh = ellipsoid(1.0, 0.8, 0.6, {.vertices = 4000});
  lay_out(mesh, {.charts = 6});
  expect_parity(mesh, {.radius = 0.05, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 256});
}

TEST_F(TexelParity, on_a_mesh_of_many_charts) {
  TestMesh mesh = torus(1.0, 0.4, {.vertices = 4000});
  lay_out(mesh, {.charts = 150});
  expect_parity(mesh, {.radius = 0.05, .evaluate = PDESC_EVALUATE_TEXEL, .texels = 512});
}

} // namespace
} // namespace paradesc::test
