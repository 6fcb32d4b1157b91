// The mask and the coverage of every vertex, and what the report counts of them.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/layout.h"
#include "support/run.h"

namespace paradesc::test {
namespace {

const std::vector<std::string> measured{"mean_curvature", "euclidean_area"};

class Masks : public OnBackend {
protected:
  Results compute(const TestMesh &mesh, const Settings &settings) {
    Results results = test::compute(context.get(), mesh, settings, measured);
    expect_the_report_to_count(results);
    return results;
  }

  static int count(const Results &results, uint8_t bit) {
    return static_cast<int>(std::ranges::count_if(results.mask, [&](uint8_t mask) { return (mask & bit) != 0; }));
  }

  // Checks the bits by their definition in the header, vertex by vertex; the report has the same counts.
  static void expect_the_report_to_count(const Results &results) {
    double coverage = 0;
    int with_face = 0, undefined = 0;
    for (size_t v = 0; v < results.mask.size(); ++v) {
      const float found = results["coverage"][v];
      const bool nowhere = (results.mask[v] & (PDESC_MASK_NO_FACE | PDESC_MASK_NO_TEXEL)) != 0;
      ASSERT_EQ((results.mask[v] & PDESC_MASK_LOW_COVERAGE) != 0, !nowhere && found < 0.9f) << "vertex " << v << ": " << found;
      ASSERT_EQ(std::isnan(results["mean_curvature"][v]), nowhere) << "vertex " << v;
      undefined += std::isnan(results["mean_curvature"][v]);
      if ((results.mask[v] & PDESC_MASK_NO_FACE) != 0) continue;
      coverage += nowhere ? 0 : static_cast<double>(found); // nothing was found of what has no place
      ++with_face;
    }
    EXPECT_EQ(results.report.low_coverage_vertices, count(results, PDESC_MASK_LOW_COVERAGE));
    EXPECT_EQ(results.report.boundary_vertices, count(results, PDESC_MASK_BOUNDARY));
    EXPECT_EQ(results.report.undefined_vertices, undefined);
    EXPECT_NEAR(results.report.coverage_mean, coverage / with_face, 1e-6) << "floats";
  }
};
PDESC_ON_EACH_BACKEND(Masks);

// Without a jump a sample is lost where its chart ends: between none and most of a neighborhood.
TEST_P(Masks, coverage_below_nine_tenths_is_low) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 60});
  // By name the processor refuses the paper's relocation.
  const int32_t relocation = GetParam() == PDESC_BACKEND_CPU ? PDESC_RELOCATION_CONNECTED : PDESC_RELOCATION_PAPER;
  const Results results = compute(mesh, {.radius = 0.04, .relocation = relocation, .max_jumps = 0});
  if (GetParam() != device_backend()) {
    EXPECT_EQ(count(results, PDESC_MASK_LOW_COVERAGE), 0) << "it needs no UV map";
    EXPECT_EQ(results.report.coverage_mean, 1);
    return;
  }
  const auto between = [&](float low, float high) {
    return std::ranges::count_if(results["coverage"], [&](float found) { return found >= low && found < high; });
  };
  EXPECT_GT(between(0.0f, 0.5f), 20);
  EXPECT_GT(between(0.5f, 0.9f), 200);
  EXPECT_GT(between(0.9f, 1.01f), 200);
}

TEST_P(Masks, a_closed_surface_has_no_boundary_and_loses_nothing) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 60});
  const Results results = compute(mesh, {.radius = 0.04});
  EXPECT_EQ(results.mask, std::vector<uint8_t>(mesh.points.size(), 0));
  if (GetParam() != device_backend()) {
    EXPECT_EQ(std::ranges::min(results["coverage"]), 1.0f) << "a march that meets the corner of a chart is lost";
  }
}

// Some hundred vertices in triangles without area in the UV map, where samples that march find no start.
TEST_P(Masks, a_vertex_without_a_place_in_the_map_is_undefined_where_samples_march) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 6});
  std::vector<uint8_t> placed(mesh.points.size(), 0);
  for (size_t corner = 0; corner < mesh.corner_vertices.size(); ++corner) {
    const size_t triangle = corner / 3;
    const bool flat = mesh.parameters[static_cast<size_t>(mesh.corner_vertices[3 * triangle])].x < 0.1;
    if (!flat) placed[static_cast<size_t>(mesh.corner_vertices[corner])] = 1;
    for (size_t axis = 0; flat && axis < 2; ++axis) mesh.corner_uvs[2 * corner + axis] = mesh.corner_uvs[6 * triangle + axis];
  }
  ASSERT_GT(std::ranges::count(placed, 0), 100);
  const Results results = compute(mesh, {.radius = 0.04});
  for (size_t v = 0; v < placed.size(); ++v) {
    const bool undefined = GetParam() == device_backend() && !placed[v];
    ASSERT_EQ((results.mask[v] & PDESC_MASK_NO_TEXEL) != 0, undefined) << "vertex " << v;
    ASSERT_EQ(std::isnan(results["mean_curvature"][v]), undefined) << "vertex " << v;
  }
}

TEST_P(Masks, a_vertex_without_a_face_is_undefined_and_has_no_other_bit) {
  TestMesh mesh = cylinder(0.5, 2, {.vertices = 2000});
  lay_out(mesh, {.charts = 6});
  const size_t loose = mesh.points.size();
  mesh.points.insert(mesh.points.end(), 5, Vec3{0.1, 0.2, 0.3});
  mesh.normals.insert(mesh.normals.end(), 5, Vec3{0, 0, 1});
  mesh.vertex_count += 5;
  round_to_float(mesh);
  const Results results = compute(mesh, {.radius = 0.04});
  for (size_t v = 0; v < mesh.points.size(); ++v)
    ASSERT_EQ((results.mask[v] & PDESC_MASK_NO_FACE) != 0, v >= loose) << "vertex " << v;
  EXPECT_EQ(count(results, PDESC_MASK_NO_FACE), 5);
  for (size_t v = loose; v < mesh.points.size(); ++v) EXPECT_EQ(results.mask[v], PDESC_MASK_NO_FACE);
  // The rim of either end, and no more than its neighborhoods.
  int rim = 0, near = 0;
  for (const double distance : mesh.boundary_distance) {
    rim += distance < 0.9 * results.report.radius;
    near += distance < 1.1 * results.report.radius;
  }
  EXPECT_GE(results.report.boundary_vertices, rim);
  EXPECT_LE(results.report.boundary_vertices, near);
  EXPECT_GT(rim, 50);
}

} // namespace
} // namespace paradesc::test
