// Surface maps where surfaces are summed over triangles: the processor and the reference, against the surfaces that the images
// stand for, and against the software device.
#include <algorithm>
#include <chrono>
#include <iostream>
#include <span>

#include "bake/mapped_shapes.h"
#include "support/api_fixture.h"
#include "support/cancel.h"
#include "support/layout.h"
#include "support/percent_ae.h"

namespace paradesc::test {
namespace {

const Descriptors curvatures{"mean_curvature", "gaussian_curvature", "local_bending_energy", "sphere_volume_normalized"};

class FollowedMaps : public SurfaceMapsTest, public ::testing::WithParamInterface<int32_t> {
protected:
  void SetUp() override {
    std::string why_not;
    context = open_context(GetParam(), why_not);
    ASSERT_TRUE(context) << why_not;
  }
};
INSTANTIATE_TEST_SUITE_P(, FollowedMaps, ::testing::Values(int32_t{PDESC_BACKEND_REFERENCE}, int32_t{PDESC_BACKEND_CPU}),
                         backend_name);

// Tests that the reference does not support (texels) or takes minutes for (filters of maps that are known at all pieces), and
// tests that do not depend on the engine.
class FollowedMapsOnCpu : public FollowedMaps {};
INSTANTIATE_TEST_SUITE_P(, FollowedMapsOnCpu, ::testing::Values(int32_t{PDESC_BACKEND_CPU}), backend_name);

double relative_difference(const std::vector<float> &a, const std::vector<float> &b, std::span<const uint8_t> subset = {}) {
  double sum = 0, difference = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!subset.empty() && !subset[i]) continue;
    sum += std::abs(static_cast<double>(b[i]));
    difference += std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
  }
  return difference / sum;
}

TEST_P(FollowedMaps, displaced_cap_has_the_curvature_of_its_sphere) {
  const TestMesh mesh = unwrapped_plane(500);
  const Settings settings{.radius = 0.12, .radius_unit = PDESC_RADIUS_ABSOLUTE};
  const Results results = run(mesh, cap_map(512), settings, curvatures);
  const auto inside = inside_the_cap(mesh, 0.15);
  const double h = 1 / cap_radius;
  for (const auto &[name, expected] :
       {std::pair("mean_curvature", h), {"gaussian_curvature", h * h}, {"local_bending_energy", h * h}}) {
    const PercentAe error = percent_ae(results[name], constant(mesh.points.size(), expected), inside);
    std::cout << name << ": mean " << error.mean << " %, max " << error.max << " % over " << error.count << " vertices\n";
    EXPECT_GT(error.count, 80);
    EXPECT_LT(error.mean, 0.03)
        << name; // the normals are those of the sphere; pieces lie inside it, by a thousandth of the radius
    EXPECT_LT(error.max, 0.06) << name;
  }
  expect_near(results["sphere_volume_normalized"], 0.5 - 3.0 / 16.0 * h * 0.12, 0.0005, inside); // eq. (8), exact on a sphere
}

TEST_P(FollowedMapsOnCpu, displaced_plane_of_few_triangles_has_the_caps_images) {
  const TestMesh mesh = unwrapped_plane(4);
  ASSERT_LT(mesh.vertex_count, 20);
  const Mesh created = make_mesh(context.get(), mesh);
  ASSERT_EQ(set_maps(created.get(), cap_map(512), static_cast<int32_t>(mesh.corner_vertices.size())), PDESC_OK);
  const int32_t size = 64;
  const pdesc_options options =
      options_of({.radius = 0.12, .radius_unit = PDESC_RADIUS_ABSOLUTE, .evaluate = PDESC_EVALUATE_TEXEL, .texels = size});
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  ASSERT_EQ(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
  const Field owner(field);
  std::vector<float> values(at(size * size));
  ASSERT_EQ(pdesc_field_map(field, name, values.data(), size * size), PDESC_OK) << pdesc_last_error();
  int inside = 0, flat = 0;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double away = std::hypot(2 * (x + 0.5) / size - 1, 2 * (y + 0.5) / size - 1), h = values[at(y * size + x)];
      if (away < rim - 0.15) {
        ASSERT_NEAR(h, 1 / cap_radius, 0.005 / cap_radius) << x << ", " << y;
        ++inside;
      } else if (away > rim + 0.16) { // the radius, and the third of it by which clusters reach beyond the ball that cuts them
        ASSERT_NEAR(h, 0, 5e-4) << x << ", " << y; // heights are floats, and slopes are their differences by a pixel
        ++flat;
      }
    }
  EXPECT_GT(inside, 700);
  EXPECT_GT(flat, 700);
}

TEST_P(FollowedMaps, a_constant_displacement_of_a_sphere_is_a_sphere_without_a_crack) {
  TestMesh mesh = sphere(1, {.vertices = 1500});
  lay_out(mesh, {.charts = 6});
  for (const double offset : {0.5, -0.4}) {
    const double r = 0.2 * (1 + offset), radius = 1 + offset;
    const Settings settings{.radius = r, .radius_unit = PDESC_RADIUS_ABSOLUTE};
    const Maps maps = displacement(
        64, 64, [](double, double) { return 1.0; }, 0.5, 2 * offset);
    const Results results = run(mesh, maps, settings, {"mean_curvature", "gaussian_curvature", "euclidean_area"});
    // The base has facets 7e-4 inside the sphere and normals fitted to them.
    expect_near(results["mean_curvature"], 1 / radius, 0.005 / radius);
    expect_near(results["gaussian_curvature"], 1 / (radius * radius), 0.01 / (radius * radius));
    expect_near(results["euclidean_area"], pi * r * r, 0.01 * pi * r * r);
    EXPECT_EQ(results.report.boundary_vertices, 0) << "charts hang together";
  }
}

TEST_P(FollowedMaps, a_displaced_torus_is_measured_as_the_software_device_measures_it) {
  const TestMesh base = unwrapped_torus(3000);
  const Maps maps = displacement(512, 512, wave, 0.5, 0.1);
  const Settings settings{.radius = 0.08, .radius_unit = PDESC_RADIUS_ABSOLUTE};
  const Results here = run(base, maps, settings, curvatures);
  std::string why_not;
  context = open_context(device_backend(), why_not);
  if (!context) GTEST_SKIP() << why_not;
  const Results software = run(base, maps, settings, curvatures);
  for (const std::string &name : curvatures) {
    const double difference = relative_difference(here[name], software[name]);
    std::cout << name << ": " << 100 * difference << " %\n";
    EXPECT_LT(difference, 0.01) << name; // of bending energy, which weighs what is nearest most; others agree ten times as well
  }
}

// A mesh's boundary stays one, and nothing else becomes one.
TEST_P(FollowedMaps, the_meshs_boundary_moves_with_the_surface) {
  const TestMesh mesh = unwrapped_plane(400);
  const Settings settings{.radius = 0.2, .radius_unit = PDESC_RADIUS_ABSOLUTE};
  const Maps far_away = displacement(16, 16, [](double, double) { return 7.0; });
  const Results base = run(mesh, {}, settings, {"mean_curvature"}), moved = run(mesh, far_away, settings, {"mean_curvature"});
  EXPECT_EQ(moved.mask, base.mask);
  EXPECT_GT(base.report.boundary_vertices, 50);
}

TEST_P(FollowedMaps, a_map_taken_away_leaves_the_same_bits) {
  TestMesh mesh = sphere(1, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(context.get(), mesh);
  const Descriptors names{"mean_curvature"};
  const Settings settings{.radius = 0.1};
  const Results before = run(created.get(), mesh, settings, names);
  const std::vector<float> heights(64 * 64, 0.3f);
  ASSERT_EQ(pdesc_mesh_set_displacement(created.get(), heights.data(), 64, 64, 0, 1), PDESC_OK);
  const Results bigger = run(created.get(), mesh, settings, names);
  EXPECT_LT(bigger[names[0]][0], 0.9f * before[names[0]][0]);
  ASSERT_EQ(pdesc_mesh_set_displacement(created.get(), nullptr, 0, 0, 0, 1), PDESC_OK);
  expect_same_bits(run(created.get(), mesh, settings, names)[names[0]], before[names[0]]);
}

// A map of the displaced surface, on which operators work: on a torus whose tube the displacement makes thicker.
TEST_P(FollowedMapsOnCpu, operators_work_on_the_displaced_surface) {
  const TestMesh thin = unwrapped_torus(2000);
  TestMesh thick = thin;
  for (size_t v = 0; v < thick.points.size(); ++v) thick.points[v] = thick.points[v] + 0.1 * thick.normals[v];
  round_to_float(thick);
  const Settings settings{.radius = 0.15, .radius_unit = PDESC_RADIUS_ABSOLUTE, .map_descriptor = "mean_curvature"};
  const Descriptors names{"gradient_magnitude", "laplacian", "difference_of_gaussians", "mean_curvature"};
  const Maps maps = displacement(32, 32, [](double, double) { return 0.1; });
  const Results displaced = run(thin, maps, settings, names), geometry = run(thick, {}, settings, names);
  for (const std::string &name : names) {
    const PercentAe error = percent_ae(displaced[name], as_double(geometry[name]));
    std::cout << name << ": mean " << error.mean << " %\n";
    // Second derivatives of a mesh with edges of half the radius; the displaced one is divided, and its map is known on all
    // pieces.
    EXPECT_LT(error.mean, name == "laplacian" ? 3 : 1) << name;
  }
}

TEST_P(FollowedMapsOnCpu, a_displaced_torus_is_measured_as_the_same_torus_in_geometry) {
  constexpr double amplitude = 0.1;
  const TestMesh base = unwrapped_torus(20000);
  TestMesh waves = base;
  for (size_t v = 0; v < waves.points.size(); ++v)
    waves.points[v] = waves.points[v] + amplitude * (wave(waves.parameters[v].x, waves.parameters[v].y) - 0.5) * waves.normals[v];
  round_to_float(waves);
  const Settings settings{.radius = 0.08, .radius_unit = PDESC_RADIUS_ABSOLUTE};
  const Results displaced = run(base, displacement(512, 512, wave, 0.5, amplitude), settings, curvatures);
  const Results geometry = run(waves, {}, settings, curvatures);
  for (const std::string &name : curvatures) {
    const PercentAe error = percent_ae(displaced[name], as_double(geometry[name]));
    std::cout << name << ": mean " << error.mean << " %, max " << error.max << " %\n";
    // Between 20000 vertices of the geometry facets cut the waves' crests, which pieces do less: the volume, which positions
    // decide, differs by that.
    EXPECT_LT(error.mean, name == "sphere_volume_normalized" ? 2.0 : 0.2) << name;
  }
}

TEST_P(FollowedMapsOnCpu, do_not_depend_on_threads) {
  const TestMesh base = unwrapped_torus(500);
  const Maps maps = displacement(256, 256, wave, 0.5, 0.1);
  const auto with = [&](int32_t threads) {
    pdesc_context_options options;
    pdesc_context_options_init(&options);
    options.backend = PDESC_BACKEND_CPU;
    options.threads = threads;
    pdesc_context *opened = nullptr;
    EXPECT_EQ(pdesc_context_create(&options, &opened), PDESC_OK);
    context.reset(opened);
    return run(base, maps, {.radius = 0.05}, curvatures);
  };
  const Results one = with(1), three = with(3);
  for (const std::string &name : curvatures) expect_same_bits(one[name], three[name]);
}

// The creases of the base end normals, and nothing else: the surface is the images'.
TEST_P(FollowedMapsOnCpu, creases_do_not_make_a_solid_of_a_displaced_surface) {
  TestMesh mesh = unwrapped_plane(400);
  for (Vec3 &point : mesh.points) point.z = std::abs(point.x); // a fold of a right angle
  round_to_float(mesh);
  const Settings settings{.radius = 0.2, .radius_unit = PDESC_RADIUS_ABSOLUTE};
  const Maps nothing = displacement(64, 64, [](double, double) { return 0.0; });
  const Results folded = run(mesh, {}, settings, {"mean_curvature"}), mapped = run(mesh, nothing, settings, {"mean_curvature"});
  ASSERT_GT(folded.report.crease_edges, 5);
  EXPECT_EQ(mapped.report.crease_edges, folded.report.crease_edges);
  double highest = 0;
  for (size_t v = 0; v < mesh.points.size(); ++v)
    if (std::abs(mesh.points[v].x) < 0.01)
      highest = std::max(highest, std::abs(static_cast<double>(folded["mean_curvature"][v] - mapped["mean_curvature"][v])));
  EXPECT_GT(highest, 0.5) << "the fold has 4/(3r) as a solid's";
}

TEST_P(FollowedMapsOnCpu, scales_beyond_all_bounds_are_refused_in_a_sentence) {
  TestMesh mesh = sphere(1, {.vertices = 400});
  lay_out(mesh, {.charts = 6});
  const Mesh created = make_mesh(context.get(), mesh);
  const float height = 1;
  for (const double scale : {1e30, 3e38}) {
    ASSERT_EQ(pdesc_mesh_set_displacement(created.get(), &height, 1, 1, 0, scale), PDESC_OK);
    const pdesc_options options = options_of({.radius = 0.1});
    const char *name = "mean_curvature";
    pdesc_field *field = nullptr;
    expect_refused(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_ERROR_INVALID_OPERATION,
                   {"displacement", "scale"});
  }
}

TEST_P(FollowedMapsOnCpu, memory_is_foreseen_with_the_pieces_and_refused_beyond_the_limit) {
  const TestMesh mesh = unwrapped_plane(100);
  pdesc_context_options limited;
  pdesc_context_options_init(&limited);
  limited.backend = PDESC_BACKEND_CPU;
  limited.memory_limit = 60'000'000;
  pdesc_context *opened = nullptr;
  ASSERT_EQ(pdesc_context_create(&limited, &opened), PDESC_OK);
  context.reset(opened);
  const Mesh created = make_mesh(context.get(), mesh);
  const pdesc_options options = options_of({.radius = 0.02});
  const char *name = "mean_curvature";
  const auto foreseen = [&] {
    pdesc_memory memory;
    pdesc_memory_init(&memory);
    EXPECT_EQ(pdesc_mesh_memory(created.get(), &options, &name, 1, PDESC_BACKEND_CPU, &memory), PDESC_OK);
    return memory.total;
  };
  const int64_t before = foreseen();
  ASSERT_EQ(set_maps(created.get(), cap_map(512), static_cast<int32_t>(mesh.corner_vertices.size())), PDESC_OK);
  EXPECT_GT(foreseen(), before + 50'000'000) << "some 200,000 pieces";
  pdesc_field *field = nullptr;
  expect_refused(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_ERROR_OUT_OF_MEMORY,
                 {"surface maps", "smaller images"});
}

TEST_P(FollowedMapsOnCpu, images_of_more_pixels_than_there_can_be_pieces_are_noted) {
  const TestMesh mesh = unwrapped_plane(4);
  const Mesh created = make_mesh(context.get(), mesh);
  const std::vector<float> heights(size_t{4096} * 4096, 0.0f);
  ASSERT_EQ(pdesc_mesh_set_displacement(created.get(), heights.data(), 4096, 4096, 0, 1), PDESC_OK);
  pdesc_options options = options_of({.radius = 0.0025});
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  ASSERT_EQ(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
  const Field owner(field);
  const std::string warnings = pdesc_field_warnings(field);
  EXPECT_NE(warnings.find("surface maps"), std::string::npos) << warnings;
  expect_one_sentence(warnings.substr(0, warnings.find('\n')));
}

TEST_P(FollowedMapsOnCpu, are_cancelled_while_the_surface_is_made) {
  const TestMesh mesh = unwrapped_plane(100);
  const Mesh created = make_mesh(context.get(), mesh);
  ASSERT_EQ(set_maps(created.get(), cap_map(512), static_cast<int32_t>(mesh.corner_vertices.size())), PDESC_OK);
  const pdesc_options options = options_of({.radius = 0.02});
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  int asked = 0;
  const pdesc_progress stop = [](void *user, const char *stage, double) -> int32_t {
    return std::string(stage) != "prepare" || ++*static_cast<int *>(user) < 2;
  };
  const std::chrono::milliseconds patience = cancel_patience;
  cancel_patience = std::chrono::milliseconds(0);
  EXPECT_EQ(pdesc_compute(created.get(), &options, &name, 1, stop, &asked, &field), PDESC_ERROR_CANCELLED);
  cancel_patience = patience;
  EXPECT_EQ(asked, 2);
  EXPECT_EQ(pdesc_compute(created.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
  const Field owner(field);
}

} // namespace
} // namespace paradesc::test
