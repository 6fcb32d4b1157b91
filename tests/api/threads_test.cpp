// Two threads at once: each with a context of its own on the same arrays, or both on one context. Run by tests/sanitize.sh thread
// too.
#include <array>
#include <string>
#include <thread>
#include <vector>

#include "support/api_fixture.h"

namespace paradesc::test {
namespace {

const std::vector<std::string> names = {"mean_curvature", "shape_index", "harris"};
const Settings settings{.radius = 0.15, .samples = 32, .buffer_size = 128};

class Threads : public OnBackend {
protected:
  void SetUp() override {
    OnBackend::SetUp();
    ball = sphere(1, {.vertices = 200});
    lay_out(ball, {.charts = 6});
  }

  // body(0) and body(1) at the same time.
  template <class Body> static void both(const Body &body) {
    std::thread other(body, 1);
    body(0);
    other.join();
  }

  void expect_same(const Results &found) {
    const Results alone = compute(context.get(), ball, settings, names);
    for (const std::string &name : names) expect_same_bits(found[name], alone[name]);
  }

  TestMesh ball;
};

TEST_P(Threads, two_contexts_on_the_same_arrays_give_what_one_gives) {
  std::array<Results, 2> found;
  both([&](int thread) {
    std::string why_not;
    const Context own = open_context(GetParam(), why_not);
    ASSERT_TRUE(own) << why_not;
    for (int round = 0; round < 2; ++round) found[static_cast<size_t>(thread)] = compute(own.get(), ball, settings, names);
  });
  for (const Results &results : found) expect_same(results);
}

TEST_P(Threads, calls_on_one_context_take_turns) {
  std::array<Results, 2> found;
  both([&](int thread) {
    for (int round = 0; round < 2; ++round) found[static_cast<size_t>(thread)] = compute(context.get(), ball, settings, names);
  });
  for (const Results &results : found) expect_same(results);
}

TEST_P(Threads, one_reads_a_mesh_while_another_computes_and_moves_it) {
  const Mesh mesh = make_mesh(context.get(), ball);
  const pdesc_options options = options_of(settings);
  both([&](int thread) {
    const char *name = "mean_curvature";
    for (int round = 0; round < 4; ++round) {
      if (thread == 0) {
        pdesc_field *field = nullptr;
        EXPECT_EQ(pdesc_mesh_set_positions(mesh.get(), ball.positions.data(), ball.vertex_count), PDESC_OK);
        EXPECT_EQ(pdesc_compute(mesh.get(), &options, &name, 1, nullptr, nullptr, &field), PDESC_OK) << pdesc_last_error();
        pdesc_field_destroy(field);
        continue;
      }
      pdesc_mesh_report report;
      pdesc_mesh_report_init(&report);
      EXPECT_EQ(pdesc_mesh_get_report(mesh.get(), &report), PDESC_OK) << pdesc_last_error();
      std::vector<float> uvs(2 * ball.corner_vertices.size());
      EXPECT_EQ(pdesc_mesh_layout(mesh.get(), uvs.data(), ball.triangle_count()), PDESC_OK) << pdesc_last_error();
      const int32_t size = pdesc_mesh_buffer_size(mesh.get());
      EXPECT_TRUE(size == 0 || size == settings.buffer_size) << size;
    }
  });
}

PDESC_ON_EACH_BACKEND(Threads);

} // namespace
} // namespace paradesc::test
