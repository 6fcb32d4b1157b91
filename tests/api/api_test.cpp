// The C interface as a stranger meets it: defaults, registry, refusals with their sentences, progress, cancel, lifetimes.
#include "paradesc/paradesc.h"

#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/run.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// The call failed with the code, and left one sentence that names each offender.
void expect_refused(int32_t status, int32_t code, std::initializer_list<const char *> offenders) {
  const std::string sentence = pdesc_last_error();
  EXPECT_EQ(status, code) << sentence;
  ASSERT_FALSE(sentence.empty());
  EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
  for (size_t dot = sentence.find(". "); dot != std::string::npos; dot = sentence.find(". ", dot + 1))
    EXPECT_FALSE(dot + 2 < sentence.size() && std::isupper(static_cast<unsigned char>(sentence[dot + 2])))
        << "two sentences: " << sentence;
  for (const char *offender : offenders)
    EXPECT_NE(sentence.find(offender), std::string::npos) << "no \"" << offender << "\" in: " << sentence;
}

// A small ball on six charts and the reference backend, which every machine has.
class Api : public ::testing::Test {
protected:
  void SetUp() override {
    ball = sphere(1, {.vertices = 400});
    lay_out(ball, {.charts = 6});
    input = input_of(ball);
    std::string why_not;
    context = open_context(PDESC_BACKEND_REFERENCE, why_not);
    ASSERT_TRUE(context) << why_not;
    pdesc_options_init(&options);
    options.radius = 0.1;
  }

  void expect_mesh_refused(std::initializer_list<const char *> offenders) {
    pdesc_mesh *mesh = never_mesh();
    expect_refused(pdesc_mesh_create(context.get(), &input, &mesh), PDESC_ERROR_INVALID_ARGUMENT, offenders);
    EXPECT_EQ(mesh, never_mesh()) << "output was touched on failure";
  }

  void expect_compute_refused(int32_t code, std::initializer_list<const char *> offenders, const char *name = "mean_curvature") {
    const Mesh mesh = make_mesh(context.get(), ball);
    ASSERT_TRUE(mesh);
    pdesc_field *field = never_field();
    expect_refused(pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, &field), code, offenders);
    EXPECT_EQ(field, never_field()) << "output was touched on failure";
  }

  std::vector<float> mean_curvature(pdesc_mesh *mesh, pdesc_progress progress = nullptr, void *user = nullptr) {
    const char *name = "mean_curvature";
    pdesc_field *field = nullptr;
    EXPECT_EQ(pdesc_compute(mesh, &options, &name, 1, progress, user, &field), PDESC_OK) << pdesc_last_error();
    const Field owner(field);
    std::vector<float> values(static_cast<size_t>(ball.vertex_count), sentinel);
    EXPECT_EQ(pdesc_field_values(field, name, values.data(), ball.vertex_count), PDESC_OK) << pdesc_last_error();
    return values;
  }

  pdesc_mesh *never_mesh() { return reinterpret_cast<pdesc_mesh *>(&place); }
  pdesc_field *never_field() { return reinterpret_cast<pdesc_field *>(&place); }

  int place = 0; // its address is the sentinel of output handles
  TestMesh ball;
  pdesc_mesh_input input;
  pdesc_options options;
  Context context;
};

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
  const int32_t backend = pdesc_context_backend(context);
  EXPECT_TRUE(backend == PDESC_BACKEND_GPU || backend == PDESC_BACKEND_SOFTWARE || backend == PDESC_BACKEND_REFERENCE);
  EXPECT_GT(std::strlen(pdesc_context_device(context)), 0u);
  EXPECT_EQ(backend == PDESC_BACKEND_REFERENCE, std::strlen(pdesc_context_fallback(context)) > 0)
      << pdesc_context_fallback(context);
}

TEST(ApiContext, unusable_options_are_refused) {
  int place = 0;
  pdesc_context *const never = reinterpret_cast<pdesc_context *>(&place);
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
  for (const uint32_t size : {0u, 8u}) {
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

// ---- Compute

TEST_F(Api, an_unknown_descriptor_is_refused_by_name) {
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"mean_curvatur3"}, "mean_curvatur3");
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"NULL"}, nullptr);
}

TEST_F(Api, an_unusable_radius_is_refused) {
  for (const double radius : {0.0, -0.5, static_cast<double>(nan), 1.5, std::numeric_limits<double>::infinity()}) {
    options.radius = radius; // a fraction of the diagonal: 1.5 is larger than the mesh
    expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"radius"});
  }
  options.radius = 0.1;
  options.radius_unit = 9;
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"radius_unit", "9"});
}

TEST_F(Api, counts_out_of_range_are_refused) {
  const auto refuse = [&](int32_t pdesc_options::*member, std::initializer_list<int32_t> values, const char *name) {
    for (const int32_t value : values) {
      pdesc_options_init(&options);
      options.*member = value;
      expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {name, std::to_string(value).c_str()});
    }
  };
  refuse(&pdesc_options::samples, {0, -1, 7, 4097}, "samples");
  refuse(&pdesc_options::buffer_size, {0, 63, 8193}, "buffer_size");
  refuse(&pdesc_options::max_jumps, {-1, 65}, "max_jumps");
  refuse(&pdesc_options::normals, {-1, 3}, "normals");
}

TEST_F(Api, null_arguments_of_compute_are_refused) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const char *name = "mean_curvature";
  pdesc_field *field = never_field();
  expect_refused(pdesc_compute(nullptr, &options, &name, 1, nullptr, nullptr, &field), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  expect_refused(pdesc_compute(mesh.get(), &options, nullptr, 1, nullptr, nullptr, &field), PDESC_ERROR_INVALID_ARGUMENT,
                 {"NULL"});
  expect_refused(pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, nullptr), PDESC_ERROR_INVALID_ARGUMENT,
                 {"NULL"});
  expect_refused(pdesc_compute(mesh.get(), &options, &name, 0, nullptr, nullptr, &field), PDESC_ERROR_INVALID_ARGUMENT, {"0"});
  EXPECT_EQ(field, never_field());
}

TEST_F(Api, mesh_normals_that_were_not_given_are_refused) {
  ball.corner_normals.clear();
  options.normals = PDESC_NORMALS_MESH;
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"normals"});
}

TEST_F(Api, without_uvs_the_reference_computes_and_the_software_backend_refuses) {
  ball.corner_uvs.clear();
  const Mesh mesh = make_mesh(context.get(), ball);
  for (const float value : mean_curvature(mesh.get())) ASSERT_TRUE(std::isfinite(value));
  std::string why_not;
  context = open_context(PDESC_BACKEND_SOFTWARE, why_not);
  if (!context) GTEST_SKIP() << why_not;
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"UV"});
}

// ---- Field

TEST_F(Api, reading_what_a_field_does_not_have_is_refused) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  ASSERT_EQ(pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
  const Field owner(field);
  const int32_t count = ball.vertex_count;
  std::vector<float> values(static_cast<size_t>(count), sentinel);
  std::vector<uint8_t> mask(static_cast<size_t>(count), mask_sentinel);
  const std::string wrong = std::to_string(count - 1);
  expect_refused(pdesc_field_values(field, "shape_index", values.data(), count), PDESC_ERROR_INVALID_ARGUMENT, {"shape_index"});
  expect_refused(pdesc_field_values(field, name, values.data(), count - 1), PDESC_ERROR_INVALID_ARGUMENT, {wrong.c_str()});
  expect_refused(pdesc_field_values(field, name, nullptr, count), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  expect_refused(pdesc_field_values(field, nullptr, values.data(), count), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  expect_refused(pdesc_field_seam_error(field, name, values.data(), count), PDESC_ERROR_INVALID_OPERATION, {"seam_error"});
  expect_refused(pdesc_field_mask(field, mask.data(), count - 1), PDESC_ERROR_INVALID_ARGUMENT, {wrong.c_str()});
  expect_refused(pdesc_mesh_near_seam(mesh.get(), 0.1, mask.data(), count - 1), PDESC_ERROR_INVALID_ARGUMENT, {wrong.c_str()});
  EXPECT_EQ(values, std::vector<float>(static_cast<size_t>(count), sentinel)) << "output was touched on failure";
  EXPECT_EQ(mask, std::vector<uint8_t>(static_cast<size_t>(count), mask_sentinel)) << "output was touched on failure";
}

TEST_F(Api, a_field_outlives_its_mesh) {
  Mesh mesh = make_mesh(context.get(), ball);
  const std::vector<float> before = mean_curvature(mesh.get());
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  ASSERT_EQ(pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
  const Field owner(field);
  mesh.reset();
  std::vector<float> values(before.size(), sentinel);
  ASSERT_EQ(pdesc_field_values(field, name, values.data(), ball.vertex_count), PDESC_OK) << pdesc_last_error();
  expect_same_bits(values, before);
}

TEST_F(Api, near_seam_marks_the_seam_and_grows_with_the_radius) {
  const Mesh mesh = make_mesh(context.get(), ball);
  int previous = 0;
  for (const double radius : {1e-6, 0.1, 0.3}) {
    std::vector<uint8_t> near(static_cast<size_t>(ball.vertex_count), mask_sentinel);
    ASSERT_EQ(pdesc_mesh_near_seam(mesh.get(), radius, near.data(), ball.vertex_count), PDESC_OK) << pdesc_last_error();
    // A way along edges is never shorter than the straight one.
    const std::vector<uint8_t> straight = near_seam(ball, radius);
    int count = 0;
    for (size_t v = 0; v < near.size(); ++v) {
      ASSERT_LE(near[v], straight[v]) << "vertex " << v << " at radius " << radius;
      count += near[v];
    }
    EXPECT_GT(count, previous);
    previous = count;
  }
}

// ---- New positions, progress, cancel

TEST_F(Api, new_positions_give_what_a_new_mesh_gives) {
  const Mesh mesh = make_mesh(context.get(), ball);
  (void)mean_curvature(mesh.get());
  scale(ball, 3);
  ASSERT_EQ(pdesc_mesh_set_positions(mesh.get(), ball.positions.data(), ball.vertex_count), PDESC_OK) << pdesc_last_error();
  const std::vector<float> moved = mean_curvature(mesh.get());
  expect_same_bits(moved, mean_curvature(make_mesh(context.get(), ball).get()));
  pdesc_mesh_report report;
  pdesc_mesh_report_init(&report);
  ASSERT_EQ(pdesc_mesh_get_report(mesh.get(), &report), PDESC_OK);
  EXPECT_FLOAT_EQ(report.diagonal, static_cast<float>(ball.diagonal()));
}

TEST_F(Api, unusable_new_positions_are_refused_and_the_old_ones_stay) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const std::vector<float> before = mean_curvature(mesh.get());
  std::vector<float> bad = ball.positions;
  expect_refused(pdesc_mesh_set_positions(mesh.get(), bad.data(), ball.vertex_count - 1), PDESC_ERROR_INVALID_ARGUMENT,
                 {std::to_string(ball.vertex_count - 1).c_str()});
  expect_refused(pdesc_mesh_set_positions(mesh.get(), nullptr, ball.vertex_count), PDESC_ERROR_INVALID_ARGUMENT, {"NULL"});
  bad[3 * 40] = nan;
  expect_refused(pdesc_mesh_set_positions(mesh.get(), bad.data(), ball.vertex_count), PDESC_ERROR_INVALID_ARGUMENT,
                 {"vertex 40"});
  expect_same_bits(mean_curvature(mesh.get()), before);
}

// Counts calls, watches what it is told, and says stop at the chosen call.
struct Watch {
  int stop_at = -1, calls = 0;
  double last = 0;
  bool sound = true;
  std::thread::id thread = std::this_thread::get_id();
  static int32_t call(void *user, const char *stage, double fraction) {
    Watch &watch = *static_cast<Watch *>(user);
    watch.sound =
        watch.sound && stage && stage[0] && fraction >= watch.last && fraction <= 1 && watch.thread == std::this_thread::get_id();
    watch.last = fraction;
    return watch.calls++ != watch.stop_at;
  }
};

class Cancel : public Api, public ::testing::WithParamInterface<int32_t> {
protected:
  void SetUp() override {
    Api::SetUp();
    std::string why_not;
    context = open_context(GetParam(), why_not);
    if (!context) GTEST_SKIP() << why_not;
  }
};
INSTANTIATE_TEST_SUITE_P(, Cancel, ::testing::Values(int32_t{PDESC_BACKEND_REFERENCE}, int32_t{PDESC_BACKEND_SOFTWARE}),
                         backend_name);

TEST_P(Cancel, progress_rises_on_the_calling_thread) {
  const Mesh mesh = make_mesh(context.get(), ball);
  Watch watch;
  (void)mean_curvature(mesh.get(), Watch::call, &watch);
  EXPECT_GE(watch.calls, 2);
  EXPECT_TRUE(watch.sound) << "a stage without a name, a fraction that falls or leaves [0, 1], or another thread";
}

TEST_P(Cancel, the_mesh_computes_again_after_a_cancel_at_any_call) {
  const Mesh mesh = make_mesh(context.get(), ball);
  Watch whole;
  const std::vector<float> expected = mean_curvature(mesh.get(), Watch::call, &whole);
  for (const int stop_at : {0, 1, whole.calls - 1}) {
    const char *name = "mean_curvature";
    Watch watch{.stop_at = stop_at};
    pdesc_field *field = never_field();
    expect_refused(pdesc_compute(mesh.get(), &options, &name, 1, Watch::call, &watch, &field), PDESC_ERROR_CANCELLED, {});
    EXPECT_EQ(watch.calls, stop_at + 1) << "was called again after it said stop";
    EXPECT_EQ(field, never_field());
    expect_same_bits(mean_curvature(mesh.get()), expected);
  }
}

} // namespace
} // namespace paradesc::test
