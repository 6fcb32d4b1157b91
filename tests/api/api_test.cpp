// The C interface as a stranger meets it: defaults, registry, contexts, meshes; each refusal with its sentence.
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <thread>

#include "support/api_fixture.h"

namespace paradesc::test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// ---- Library

TEST(ApiLibrary, has_the_version_of_its_header) {
  EXPECT_EQ(pdesc_abi_version(), PDESC_ABI_VERSION);
  EXPECT_GT(std::strlen(pdesc_version()), 0u);
}

// A byte pattern below shows every member that init forgets.
template <class Struct> Struct initialized(void (*init)(Struct *)) {
  Struct s;
  std::memset(&s, 0xA5, sizeof s);
  init(&s);
  EXPECT_EQ(s.struct_size, sizeof s);
  return s;
}

TEST(ApiLibrary, init_sets_size_and_documented_defaults) {
  const pdesc_options options = initialized(pdesc_options_init);
  EXPECT_EQ(options.radius, 0.02);
  EXPECT_EQ(options.radius_unit, PDESC_RADIUS_DIAGONAL);
  EXPECT_EQ(options.samples, 256);
  EXPECT_EQ(options.buffer_size, 1024);
  EXPECT_EQ(options.normals, PDESC_NORMALS_FITTED);
  EXPECT_EQ(options.max_jumps, 8);
  EXPECT_EQ(options.seed, 0u);
  EXPECT_EQ(options.seam_error, 0);

  const pdesc_context_options context = initialized(pdesc_context_options_init);
  EXPECT_EQ(context.backend, PDESC_BACKEND_AUTO);
  EXPECT_EQ(context.device_index, -1);
  EXPECT_EQ(context.threads, 0);

  const pdesc_mesh_input input = initialized(pdesc_mesh_input_init);
  EXPECT_EQ(input.vertex_count + input.corner_count + input.triangle_count + input.sharp_edge_count, 0);
  EXPECT_EQ(input.positions, nullptr);
  EXPECT_EQ(input.corner_vertices, nullptr);
  EXPECT_EQ(input.triangle_corners, nullptr);
  EXPECT_EQ(input.corner_uvs, nullptr);
  EXPECT_EQ(input.corner_normals, nullptr);
  EXPECT_EQ(input.triangle_smooth, nullptr);
  EXPECT_EQ(input.sharp_edges, nullptr);

  initialized(pdesc_descriptor_info_init);
  EXPECT_EQ(initialized(pdesc_mesh_report_init).vertex_count, 0);
  EXPECT_EQ(initialized(pdesc_field_report_init).undefined_vertices, 0);
}

TEST(ApiLibrary, init_of_nothing_does_nothing) {
  pdesc_options_init(nullptr);
  pdesc_context_options_init(nullptr);
  pdesc_mesh_input_init(nullptr);
  pdesc_descriptor_info_init(nullptr);
  pdesc_mesh_report_init(nullptr);
  pdesc_field_report_init(nullptr);
  pdesc_context_destroy(nullptr);
  pdesc_mesh_destroy(nullptr);
  pdesc_field_destroy(nullptr);
}

TEST(ApiRegistry, rows_are_complete_and_names_are_unique) {
  std::set<std::string> names;
  ASSERT_GE(pdesc_descriptor_count(), 9);
  for (int32_t i = 0; i < pdesc_descriptor_count(); ++i) {
    pdesc_descriptor_info info = initialized(pdesc_descriptor_info_init);
    ASSERT_EQ(pdesc_descriptor_get(i, &info), PDESC_OK) << pdesc_last_error();
    for (const char *text : {info.name, info.label, info.description}) {
      ASSERT_NE(text, nullptr);
      EXPECT_GT(std::strlen(text), 0u);
    }
    EXPECT_TRUE(names.insert(info.name).second) << info.name << " twice";
    EXPECT_EQ(std::string(info.name).find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789"), std::string::npos) << info.name;
    EXPECT_TRUE(info.is_signed == 0 || info.is_signed == 1);
    EXPECT_GE(info.length_power, -2) << info.name;
    EXPECT_LE(info.length_power, 3) << info.name;
    EXPECT_EQ(std::isnan(info.display_minimum), std::isnan(info.display_maximum)) << info.name;
  }
  EXPECT_TRUE(names.count("mean_curvature"));
  EXPECT_FALSE(names.count("coverage")) << "coverage stands beside every result and is no descriptor";
}

TEST(ApiRegistry, index_out_of_range_is_refused) {
  for (const int32_t index : {-1, pdesc_descriptor_count()}) {
    pdesc_descriptor_info info = initialized(pdesc_descriptor_info_init);
    info.name = "untouched";
    expect_refused(pdesc_descriptor_get(index, &info), PDESC_ERROR_INVALID_ARGUMENT, {std::to_string(index).c_str()});
    EXPECT_STREQ(info.name, "untouched");
  }
  expect_refused(pdesc_descriptor_get(0, nullptr), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
}

TEST(ApiLibrary, last_error_belongs_to_its_thread) {
  EXPECT_NE(pdesc_descriptor_get(-1, nullptr), PDESC_OK);
  EXPECT_STRNE(pdesc_last_error(), "");
  std::thread([] { EXPECT_STREQ(pdesc_last_error(), ""); }).join();
}

// ---- Context

TEST(ApiContext, defaults_come_from_null_options) {
  pdesc_context *context = nullptr;
  ASSERT_EQ(pdesc_context_create(nullptr, &context), PDESC_OK) << pdesc_last_error();
  const Context owner(context);
  EXPECT_EQ(pdesc_context_backend(context), PDESC_BACKEND_CPU);
  EXPECT_GT(std::strlen(pdesc_context_device(context)), 0u);
  EXPECT_STREQ(pdesc_context_fallback(context), "");
}

TEST(ApiContext, unusable_options_are_refused) {
  int sentinel_address = 0;
  pdesc_context *const never = reinterpret_cast<pdesc_context *>(&sentinel_address);
  pdesc_context *context = never;
  pdesc_context_options options = initialized(pdesc_context_options_init);
  options.backend = 17;
  expect_refused(pdesc_context_create(&options, &context), PDESC_ERROR_INVALID_ARGUMENT, {"backend", "17"});
  options = initialized(pdesc_context_options_init);
  options.threads = -3;
  expect_refused(pdesc_context_create(&options, &context), PDESC_ERROR_INVALID_ARGUMENT, {"threads", "-3"});
  for (const uint32_t size : {0u, 4u}) {
    options = initialized(pdesc_context_options_init);
    options.struct_size = size;
    expect_refused(pdesc_context_create(&options, &context), PDESC_ERROR_INVALID_ARGUMENT, {"struct_size"});
  }
  options = initialized(pdesc_context_options_init);
  options.backend = PDESC_BACKEND_REFERENCE;
  expect_refused(pdesc_context_create(&options, nullptr), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  EXPECT_EQ(context, never);
}

// ---- Mesh

TEST_F(Api, null_arguments_of_mesh_create_are_refused) {
  pdesc_mesh *mesh = never_mesh();
  expect_refused(pdesc_mesh_create(nullptr, &input, &mesh), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  expect_refused(pdesc_mesh_create(context.get(), nullptr, &mesh), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  expect_refused(pdesc_mesh_create(context.get(), &input, nullptr), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  EXPECT_EQ(mesh, never_mesh());
}

TEST_F(Api, missing_arrays_are_refused_by_name) {
  input.positions = nullptr;
  expect_mesh_refused({"positions"});
  input = input_of(ball);
  input.corner_vertices = nullptr;
  expect_mesh_refused({"corner_vertices"});
  input = input_of(ball);
  input.triangle_corners = nullptr;
  expect_mesh_refused({"triangle_corners"});
}

TEST_F(Api, struct_size_of_another_library_is_refused) {
  for (const uint32_t size : {0u, 4u}) {
    input = input_of(ball);
    input.struct_size = size;
    expect_mesh_refused({"struct_size"});
    pdesc_options_init(&options);
    options.struct_size = size;
    expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"struct_size"});
  }
}

TEST_F(Api, a_mesh_without_faces_is_refused) {
  input.triangle_count = 0;
  expect_mesh_refused({"triangle"});
}

TEST_F(Api, negative_counts_are_refused) {
  input.vertex_count = -5;
  expect_mesh_refused({"-5"});
  input = input_of(ball);
  input.triangle_count = -6;
  expect_mesh_refused({"-6"});
  input = input_of(ball);
  input.corner_count = -7;
  expect_mesh_refused({"-7"});
}

TEST_F(Api, a_coordinate_that_is_no_number_is_refused_with_its_vertex) {
  for (const float bad : {nan, std::numeric_limits<float>::infinity()}) {
    ball.positions[3 * 17 + 1] = bad;
    input = input_of(ball);
    expect_mesh_refused({"vertex 17"});
  }
}

TEST_F(Api, a_uv_that_is_no_number_is_refused_with_its_corner) {
  ball.corner_uvs[2 * 23] = nan;
  input = input_of(ball);
  expect_mesh_refused({"corner 23"});
}

TEST_F(Api, an_index_out_of_range_is_refused_with_its_place_and_value) {
  ball.corner_vertices[31] = ball.vertex_count;
  expect_mesh_refused({"corner 31", std::to_string(ball.vertex_count).c_str()});
  ball.corner_vertices[31] = -2;
  expect_mesh_refused({"corner 31", "-2"});
  ball.corner_vertices[31] = 0;
  ball.triangle_corners[3 * 5 + 2] = 999999;
  expect_mesh_refused({"triangle 5", "999999"});
}

TEST_F(Api, the_report_counts_charts_and_seams) {
  const Mesh mesh = make_mesh(context.get(), ball);
  pdesc_mesh_report report;
  pdesc_mesh_report_init(&report);
  ASSERT_EQ(pdesc_mesh_get_report(mesh.get(), &report), PDESC_OK) << pdesc_last_error();
  EXPECT_EQ(report.vertex_count, ball.vertex_count);
  EXPECT_EQ(report.triangle_count, ball.triangle_count());
  EXPECT_EQ(report.charts, 6);
  EXPECT_GT(report.seam_edges, 0);
  EXPECT_EQ(report.self_seam_edges, 0);
  EXPECT_EQ(report.boundary_edges, 0);
  EXPECT_EQ(report.parts, 1);
  EXPECT_EQ(report.loose_vertices + report.welded_vertices + report.degenerate_triangles + report.zero_uv_area_triangles, 0);
  EXPECT_FLOAT_EQ(report.diagonal, static_cast<float>(ball.diagonal()));
  report.struct_size = 0;
  expect_refused(pdesc_mesh_get_report(mesh.get(), &report), PDESC_ERROR_INVALID_ARGUMENT, {"struct_size"});
}

} // namespace
} // namespace paradesc::test
