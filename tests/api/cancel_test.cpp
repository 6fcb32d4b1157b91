// Cancelling anywhere: while a mesh is made, and at every call of the callback, with what is computed afterwards.
#include <atomic>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "mesh/charts.h"
#include "mesh/cluster_tree.h"
#include "mesh/creases.h"
#include "mesh/normal_rings.h"
#include "support/api_fixture.h"
#include "support/cancel.h"
#include "support/checkpoints.h"
#include "support/creases.h"
#include "support/error.h"
#include "support/parallel.h"
#include "support/solids.h"

namespace paradesc::test {
namespace {

// Says stop at one call.
struct Stop {
  int at = -1;
  int calls = 0;
  static int32_t call(void *user, const char *, double) {
    Stop &stop = *static_cast<Stop *>(user);
    return stop.calls++ != stop.at;
  }
};

TEST(Checkpoint, without_a_scope_does_nothing) { checkpoint(); }

TEST(Checkpoint, asks_on_the_thread_of_the_scope_alone_and_ends_all_threads) {
  std::atomic<int> asks{0}, elsewhere{0};
  const auto owner = std::this_thread::get_id();
  const auto cancelled = [&] {
    const CancelScope scope([&] {
      elsewhere += std::this_thread::get_id() != owner;
      if (++asks == 3) throw Error(PDESC_ERROR_CANCELLED, "stop");
    });
    parallel_blocks(1 << 20, 2, 1, [](int, int) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); });
  };
  EXPECT_THROW(cancelled(), Error); // or it would last for half an hour
  EXPECT_EQ(asks, 3);
  EXPECT_EQ(elsewhere, 0);
  checkpoint(); // the scope is gone
}

TEST(Checkpoint, is_not_asked_too_soon_nor_while_the_caller_answers) {
  const std::chrono::milliseconds patience = cancel_patience;
  int asks = 0;
  const CancelScope scope([&] {
    ++asks;
    checkpoint(); // as a caller that uses the library in its callback
  });
  cancel_patience = std::chrono::hours(1);
  checkpoint();
  EXPECT_EQ(asks, 0) << "too soon";
  cancel_patience = std::chrono::milliseconds(0);
  checkpoint();
  EXPECT_EQ(asks, 1);
  cancel_patience = patience;
}

TEST(Checkpoint, asks_while_the_other_threads_end_their_last_blocks) {
  const auto owner = std::this_thread::get_id();
  std::atomic<bool> begun{false};
  const auto cancelled = [&] {
    const CancelScope scope([] { throw Error(PDESC_ERROR_CANCELLED, "stop"); });
    parallel_blocks(2, 2, 1, [&](int, int) {
      if (std::this_thread::get_id() == owner) {
        while (!begun) std::this_thread::yield(); // both have a block
        return;
      }
      begun = true;
      for (int i = 0; i < 20000; ++i) { // to its end, if nobody asks
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        checkpoint();
      }
    });
  };
  EXPECT_THROW(cancelled(), Error);
}

// A stage without any would let a caller wait for all of it.
TEST(Checkpoint, comes_once_in_so_many_steps_of_every_stage_of_a_large_mesh) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 70000});
  lay_out(mesh, {.charts = 4});
  const pdesc_mesh_input input = input_of(mesh);
  const int corners = 3 * input.triangle_count / 32768;
  ASSERT_GE(corners, 10);
  Triangles triangles;
  HalfEdges half_edges;
  Creases creases;
  EXPECT_GE(checkpoints_of([&] { triangles = read_triangles(input); }), 3 * corners);
  EXPECT_GE(checkpoints_of([&] { half_edges = build_half_edges(triangles, 1); }), 10 * corners);
  EXPECT_GE(checkpoints_of([&] { build_charts(triangles, half_edges, {}, 1); }), 20 * corners);
  EXPECT_GE(checkpoints_of([&] { build_point_tree(find_point_neighbors(half_edges)); }), 6 * corners);
  const int of_faces = input.triangle_count / 1024; // whose normals and bends are looked at
  EXPECT_GE(checkpoints_of([&] { creases = creases_of(triangles, half_edges, 1); }), 2 * of_faces);
  Triangles hard = box(110); // with creases that stand out, and all edges marked
  std::ranges::fill(hard.half_edge_sharp, uint8_t{1});
  const HalfEdges of_hard = build_half_edges(hard, 1);
  const int hard_faces = hard.triangle_count / 1024, hard_edges = 3 * hard.triangle_count / 2 / 32768;
  ASSERT_GE(hard_edges, 6);
  EXPECT_GE(checkpoints_of([&] { creases_of(hard, of_hard, 1); }), 2 * hard_faces + 9 * hard_edges);
  NormalRings rings;
  EXPECT_GE(checkpoints_of([&] { find_fans(triangles, half_edges, creases, rings); }), 2 * corners);
}

class CancelAnywhere : public Api, public ::testing::WithParamInterface<int32_t> {
protected:
  void SetUp() override {
    Api::SetUp();
    ball = sphere(1, {.vertices = 100});
    lay_out(ball, {.charts = 6});
    input = input_of(ball);
    std::string why_not;
    context = open_context(GetParam(), why_not);
    if (!context) GTEST_SKIP() << why_not;
    options.buffer_size = 64;
    options.radius = 0.2;
    options.samples = 16;
    cancel_patience = std::chrono::milliseconds(0);
  }
  void TearDown() override { cancel_patience = patience; }

  // A run that is stopped at this call; false where it came to its end before.
  bool cancel_at(int call, pdesc_mesh *mesh) {
    const char *name = "mean_curvature";
    Stop stop{call};
    pdesc_field *field = nullptr;
    const int32_t status = pdesc_compute(mesh, &options, &name, 1, Stop::call, &stop, &field);
    const Field owner(field);
    EXPECT_GT(stop.calls, 0) << "it was never asked";
    if (status != PDESC_OK) {
      EXPECT_EQ(status, PDESC_ERROR_CANCELLED) << pdesc_last_error();
      EXPECT_EQ(stop.calls, call + 1) << "was called again after it said stop";
    }
    return status == PDESC_ERROR_CANCELLED;
  }

  const std::chrono::milliseconds patience = cancel_patience;
};
PDESC_ON_EACH_BACKEND(CancelAnywhere);

TEST_P(CancelAnywhere, the_first_run_of_a_mesh_leaves_it_as_new) {
  const std::vector<float> expected = mean_curvature(make_mesh(context.get(), ball).get());
  for (int call = 0;; ++call) {
    const Mesh mesh = make_mesh(context.get(), ball);
    if (!cancel_at(call, mesh.get())) break;
    expect_same_bits(mean_curvature(mesh.get()), expected);
  }
}

TEST_P(CancelAnywhere, a_run_at_another_size_and_precision_leaves_what_was_baked_usable) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const std::vector<float> expected = mean_curvature(mesh.get());
  const pdesc_options usual = options;
  bool cancelled = true;
  for (int call = 0; cancelled; ++call) {
    options.buffer_size = 192;
    if (GetParam() == PDESC_BACKEND_CPU) { // which has texels instead
      options.evaluate = PDESC_EVALUATE_TEXEL;
      options.texels = 32;
    } else {
      options.precision = PDESC_PRECISION_HALF;
    }
    options.normals = PDESC_NORMALS_MAX;
    cancelled = cancel_at(call, mesh.get());
    options = usual;
    expect_same_bits(mean_curvature(mesh.get()), expected);
  }
}

// The size alone: nothing else says that what was baked for the last one does not hold.
TEST_P(CancelAnywhere, a_run_at_another_size_alone_is_done_again_whole) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const std::vector<float> expected = mean_curvature(mesh.get());
  const pdesc_options usual = options;
  options.buffer_size = 96;
  const pdesc_options larger = options;
  const std::vector<float> expected_larger = mean_curvature(make_mesh(context.get(), ball).get());
  for (int call = 0; cancel_at(call, mesh.get()); ++call) {
    expect_same_bits(mean_curvature(mesh.get()), expected_larger);
    options = usual;
    expect_same_bits(mean_curvature(mesh.get()), expected);
    options = larger;
  }
}

TEST_P(CancelAnywhere, new_positions_are_baked_whole_after_it) {
  TestMesh bent = ball;
  for (Vec3 &p : bent.points) p = {p.x + 0.3 * std::sin(2 * p.y), p.y, p.z + 0.2 * p.x * p.y};
  round_to_float(bent);
  const TestMesh *const shapes[] = {&bent, &ball};
  std::vector<float> expected[2];
  for (size_t i = 0; i < 2; ++i) expected[i] = mean_curvature(make_mesh(context.get(), *shapes[i]).get());
  ASSERT_NE(expected[0], expected[1]);
  const Mesh mesh = make_mesh(context.get(), ball);
  (void)mean_curvature(mesh.get());
  bool cancelled = true;
  for (int call = 0; cancelled; ++call) { // other positions every time, or there would be nothing to bake
    const auto shape = static_cast<size_t>(call % 2);
    ASSERT_EQ(pdesc_mesh_set_positions(mesh.get(), shapes[shape]->positions.data(), ball.vertex_count), PDESC_OK)
        << pdesc_last_error();
    cancelled = cancel_at(call, mesh.get());
    expect_same_bits(mean_curvature(mesh.get()), expected[shape]);
  }
}

TEST_P(CancelAnywhere, charts_that_overlap_are_laid_out_once_and_whole) {
  for (float &uv : ball.corner_uvs) uv = 0.5f * uv + (uv < 0.5f ? 0.25f : 0.0f);
  const std::vector<float> expected = mean_curvature(make_mesh(context.get(), ball).get());
  const char *name = "mean_curvature";
  for (int call = 0;; ++call) {
    const Mesh mesh = make_mesh(context.get(), ball);
    if (!cancel_at(call, mesh.get())) break;
    pdesc_field *field = nullptr;
    ASSERT_EQ(pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
    const Field owner(field);
    pdesc_field_report report;
    pdesc_field_report_init(&report);
    ASSERT_EQ(pdesc_field_get_report(field, &report), PDESC_OK);
    EXPECT_EQ(report.private_layout, GetParam() == device_backend() ? PDESC_LAYOUT_OVERLAPS : PDESC_LAYOUT_GIVEN);
    std::vector<float> values(expected.size(), sentinel);
    ASSERT_EQ(pdesc_field_values(field, name, values.data(), ball.vertex_count), PDESC_OK);
    expect_same_bits(values, expected);
  }
}

TEST_P(CancelAnywhere, a_mesh_of_which_half_was_made_is_given_up) {
  input.user = nullptr;
  input.progress = Stop::call;
  for (int call = 0;; ++call) {
    Stop stop{call};
    input.user = &stop;
    pdesc_mesh *mesh = never_mesh();
    const int32_t status = pdesc_mesh_create(context.get(), &input, &mesh);
    if (status == PDESC_OK) {
      const Mesh owner(mesh);
      EXPECT_GT(call, 0) << "it was never asked";
      break;
    }
    EXPECT_EQ(status, PDESC_ERROR_CANCELLED) << pdesc_last_error();
    EXPECT_EQ(mesh, never_mesh());
    EXPECT_EQ(stop.calls, call + 1) << "was called again after it said stop";
  }
}

} // namespace
} // namespace paradesc::test
