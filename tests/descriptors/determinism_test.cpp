// The same bits again on one device: over runs, over threads, over tiles; every descriptor, at vertices and at texels.
// paradesc.h says how much another device may differ.
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "compute/compute.h"
#include "context.h"
#include "support/error.h"
#include "support/layout.h"
#include "support/run.h"
#include "support/surfaces.h"

#include "shared.h"

namespace paradesc {
namespace {

struct Way {
  int threads = 0;
  int smallest_tile = 8 * 16;
};

class Determinism : public ::testing::TestWithParam<int32_t> {
protected:
  void SetUp() override {
    std::string why_not;
    if (!test::open_context(GetParam(), why_not)) GTEST_SKIP() << why_not;
    // Many charts, and an open border of needles and slivers.
    mesh = test::saddle(1, {.vertices = 300});
    test::lay_out(mesh, {.charts = 15});
    settings = {.radius = 0.06, .samples = 32, .buffer_size = 256, .texels = 64, .map_sigma = 0.5};
  }

  static std::shared_ptr<Context> open() {
    pdesc_context_options requested;
    pdesc_context_options_init(&requested);
    requested.backend = GetParam();
    return make_context(requested);
  }

  Field compute_by(const std::shared_ptr<Context> &context, const Way &way) const {
    context->threads = way.threads;
    context->smallest_tile = way.smallest_tile;
    const auto native = make_mesh(context, input_of(mesh));
    const pdesc_options options = test::options_of(settings);
    std::vector<int> rows;
    for (int row = 0; row < pdesc_descriptor_count(); ++row) {
      const bool at_texels = settings.evaluate == PDESC_EVALUATE_TEXEL;
      if (!at_texels || test::map_degree_of(test::registered_descriptors()[static_cast<size_t>(row)]) == 0) rows.push_back(row);
    }
    return compute(*native, options, rows, [](const char *, double) { return true; });
  }

  static void expect_same(const std::vector<std::vector<float>> &a, const std::vector<std::vector<float>> &b,
                          const Field &field) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      SCOPED_TRACE(i < field.names.size() ? field.names[i] : "coverage");
      test::expect_same_bits(a[i], b[i]);
    }
  }

  static void expect_same(const Field &a, const Field &b) {
    expect_same(a.values, b.values, a);
    expect_same(a.maps, b.maps, a);
    EXPECT_EQ(a.mask, b.mask);
    EXPECT_EQ(a.warnings, b.warnings);
    EXPECT_EQ(a.report.bare_triangles, b.report.bare_triangles);
    EXPECT_EQ(a.report.covered_texels, b.report.covered_texels);
    EXPECT_EQ(a.report.coverage_mean, b.report.coverage_mean);
    EXPECT_EQ(a.report.refined_share, b.report.refined_share);
  }

  // Once more, by more threads than the machine has cores, and in tiles from one work group to all at once.
  void expect_one_result() const {
    const Field first = compute_by(open(), {});
    ASSERT_FALSE(first.values.empty());
    const auto context = open();
    std::vector<Way> ways = {Way{1}, Way{2}, Way{4}};
    if (GetParam() == test::device_backend()) ways.insert(ways.end(), {Way{0, 16}, Way{0, 1 << 20}}); // others have no tiles
    for (const Way &way : ways) {
      SCOPED_TRACE(std::to_string(way.threads) + " threads, tiles of " + std::to_string(way.smallest_tile));
      expect_same(first, compute_by(context, way));
    }
  }

  test::TestMesh mesh;
  test::Settings settings;
};

TEST_P(Determinism, every_descriptor_has_the_same_bits_at_vertices) { expect_one_result(); }

TEST_P(Determinism, every_descriptor_has_the_same_bits_at_texels) {
  if (GetParam() == PDESC_BACKEND_REFERENCE) GTEST_SKIP() << "it computes at vertices alone";
  settings.evaluate = PDESC_EVALUATE_TEXEL;
  expect_one_result();
}

TEST_P(Determinism, integrals_over_adaptive_samples_have_the_same_bits) {
  settings.estimator = PDESC_ESTIMATOR_INTEGRAL;
  if (GetParam() != PDESC_BACKEND_CPU) settings.adaptive = 0.05;
  expect_one_result();
}

TEST_P(Determinism, the_papers_way_over_seams_has_the_same_bits) {
  if (GetParam() != test::device_backend()) GTEST_SKIP() << "samples march in texture space";
  settings.relocation = PDESC_RELOCATION_PAPER;
  settings.max_jumps = 2;
  expect_one_result();
}

TEST_P(Determinism, a_mesh_computes_the_same_bits_again) {
  settings.samples = 8;
  const auto native = make_mesh(open(), input_of(mesh));
  const std::vector<int> rows = {0, 1};
  pdesc_options options = test::options_of(settings);
  const auto go = [&] { return compute(*native, options, rows, [](const char *, double) { return true; }); };
  const Field first = go();
  options.radius = 0.2; // another one in between
  go();
  options.radius = settings.radius;
  expect_same(first, go());
}

INSTANTIATE_TEST_SUITE_P(, Determinism,
                         ::testing::Values(int32_t{PDESC_BACKEND_REFERENCE}, test::device_backend(), int32_t{PDESC_BACKEND_CPU}),
                         test::backend_name);

} // namespace
} // namespace paradesc
