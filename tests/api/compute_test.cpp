// Computing through the C interface: refusals, fields, new positions, progress, cancel.
#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include "support/api_fixture.h"

namespace paradesc::test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

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

TEST_F(Api, huge_and_tiny_numbers_are_named_in_few_digits) {
  options.radius_unit = PDESC_RADIUS_ABSOLUTE;
  options.radius = 1e300;
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"The radius is 1e+300, but"});
  options.radius = -1e-300;
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"The radius is -1e-300;"});
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
  refuse(&pdesc_options::texels, {15, 8193}, "texels");
  refuse(&pdesc_options::relocation, {-1, 3}, "relocation");
  refuse(&pdesc_options::estimator, {-1, 3}, "estimator");
  refuse(&pdesc_options::evaluate, {-1, 2}, "evaluate");
  refuse(&pdesc_options::precision, {-1, 2}, "precision");
}

TEST_F(Api, options_of_operators_out_of_range_are_refused) {
  const double infinite = std::numeric_limits<double>::infinity();
  const auto refuse = [&](double pdesc_options::*member, std::initializer_list<double> values, const char *name) {
    for (const double value : values) {
      pdesc_options_init(&options);
      options.*member = value;
      expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {name}, "harris");
    }
  };
  refuse(&pdesc_options::adaptive, {-0.1, static_cast<double>(nan), infinite}, "adaptive");
  refuse(&pdesc_options::map_sigma, {0.0, -1.0, 4.1, static_cast<double>(nan)}, "map_sigma");
  refuse(&pdesc_options::harris_k, {-0.01, 0.25, static_cast<double>(nan), infinite}, "harris_k");
}

TEST_F(Api, seam_errors_are_refused_and_the_way_now_is_named) {
  options.seam_error = 1;
  expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {"seam_error", "pdesc_mesh_near_seam"});
}

TEST_F(Api, a_map_is_a_descriptor_of_the_surface_with_one_component) {
  for (const char *name : {"principal_direction_max", "harris", "laplacian"}) {
    options.map_descriptor = name;
    expect_compute_refused(PDESC_ERROR_INVALID_ARGUMENT, {name, "map"}, "gradient_magnitude");
  }
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
  expect_compute_refused(PDESC_ERROR_INVALID_OPERATION, {"normals"});
}

TEST_F(Api, without_uvs_the_reference_computes_and_the_software_backend_refuses) {
  ball.corner_uvs.clear();
  const Mesh mesh = make_mesh(context.get(), ball);
  for (const float value : mean_curvature(mesh.get())) ASSERT_TRUE(std::isfinite(value));
  std::string why_not;
  context = open_context(device_backend(), why_not);
  if (!context) GTEST_SKIP() << why_not;
  expect_compute_refused(PDESC_ERROR_INVALID_OPERATION, {"UV"});
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
  for (const double radius : {1e-6, 0.3, 0.6}) {
    std::vector<uint8_t> near(static_cast<size_t>(ball.vertex_count), mask_sentinel);
    ASSERT_EQ(pdesc_mesh_near_seam(mesh.get(), radius, near.data(), ball.vertex_count), PDESC_OK) << pdesc_last_error();
    // An edge is 0.2 long. A way along edges is never shorter than the straight one.
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

TEST_F(Api, a_boundary_is_no_seam) {
  TestMesh sheet = plane(1.0, 1.0, {.vertices = 100});
  lay_out(sheet, {.charts = 1});
  const Mesh mesh = make_mesh(context.get(), sheet);
  std::vector<uint8_t> near(static_cast<size_t>(sheet.vertex_count), mask_sentinel);
  ASSERT_EQ(pdesc_mesh_near_seam(mesh.get(), 0.5, near.data(), sheet.vertex_count), PDESC_OK) << pdesc_last_error();
  EXPECT_EQ(near, std::vector<uint8_t>(near.size(), 0));
}

TEST_F(Api, a_distance_to_seams_that_is_none_is_refused) {
  const Mesh mesh = make_mesh(context.get(), ball);
  std::vector<uint8_t> near(static_cast<size_t>(ball.vertex_count), mask_sentinel);
  for (const double radius : {-1e-3, static_cast<double>(nan), std::numeric_limits<double>::infinity()})
    expect_refused(pdesc_mesh_near_seam(mesh.get(), radius, near.data(), ball.vertex_count), PDESC_ERROR_INVALID_ARGUMENT,
                   {"radius"});
  EXPECT_EQ(near, std::vector<uint8_t>(near.size(), mask_sentinel)) << "output was touched on failure";
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

// A mesh keeps normals and buffers from one computation to the next only while nothing but the radius changes.
TEST_F(Api, each_computation_gives_what_a_new_mesh_gives_whatever_came_before) {
  std::string why_not;
  context = open_context(device_backend(), why_not);
  if (!context) GTEST_SKIP() << why_not;
  options.buffer_size = 256;
  const Mesh kept = make_mesh(context.get(), ball);
  const std::vector<float> heights(16, 0.1f);
  bool displaced = false;
  auto step = [&](const char *what) {
    const Mesh fresh = make_mesh(context.get(), ball);
    if (displaced) {
      ASSERT_EQ(pdesc_mesh_set_displacement(fresh.get(), heights.data(), 4, 4, 0.0, 1.0), PDESC_OK);
    }
    SCOPED_TRACE(what);
    expect_same_bits(mean_curvature(kept.get()), mean_curvature(fresh.get()));
  };
  step("at first");
  options.radius = 0.2;
  step("another radius");
  options.samples = 64;
  step("fewer samples");
  options.seed = 7;
  step("another seed");
  options.normals = PDESC_NORMALS_MAX;
  step("other normals");
  options.evaluate = PDESC_EVALUATE_TEXEL;
  step("at texels");
  options.evaluate = PDESC_EVALUATE_VERTEX;
  options.precision = PDESC_PRECISION_HALF;
  step("half floats");
  options.buffer_size = 512;
  step("larger buffers");
  for (float &position : ball.positions) position *= 1.5f;
  ASSERT_EQ(pdesc_mesh_set_positions(kept.get(), ball.positions.data(), ball.vertex_count), PDESC_OK);
  step("new positions");
  ASSERT_EQ(pdesc_mesh_set_displacement(kept.get(), heights.data(), 4, 4, 0.0, 1.0), PDESC_OK);
  displaced = true;
  step("displaced");
  options.relocation = PDESC_RELOCATION_AFFINE;
  step("affine");
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

// Counts calls, watches what it is told, and says stop at the chosen call, or from the chosen fraction on: how many calls there
// are depends on how fast the device is.
struct Watch {
  int stop_at = -1;
  double stop_from = 2;
  int calls = 0, calls_after_stop = 0;
  double last = 0;
  bool stopped = false;
  bool sound = true;
  std::thread::id thread = std::this_thread::get_id();
  static int32_t call(void *user, const char *stage, double fraction) {
    Watch &watch = *static_cast<Watch *>(user);
    watch.sound =
        watch.sound && stage && stage[0] && fraction >= watch.last && fraction <= 1 && watch.thread == std::this_thread::get_id();
    watch.last = fraction;
    watch.calls_after_stop += watch.stopped;
    watch.stopped = watch.stopped || watch.calls++ == watch.stop_at || fraction >= watch.stop_from;
    return !watch.stopped;
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
INSTANTIATE_TEST_SUITE_P(, Cancel,
                         ::testing::Values(int32_t{PDESC_BACKEND_REFERENCE}, device_backend(), int32_t{PDESC_BACKEND_CPU}),
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
  for (Watch watch : {Watch{.stop_at = 0}, Watch{.stop_at = 1}, Watch{.stop_from = 0.5}, Watch{.stop_from = whole.last}}) {
    const char *name = "mean_curvature";
    pdesc_field *field = never_field();
    expect_refused(pdesc_compute(mesh.get(), &options, &name, 1, Watch::call, &watch, &field), PDESC_ERROR_CANCELLED, {});
    EXPECT_EQ(watch.calls_after_stop, 0) << "was called again after it said stop";
    EXPECT_EQ(field, never_field());
    expect_same_bits(mean_curvature(mesh.get()), expected);
  }
}

} // namespace
} // namespace paradesc::test
