// A mesh keeps arrays from one computation to the next. After its input has changed, every result is that of a new mesh, bit for
// bit.
#include <cmath>
#include <iterator>
#include <set>

#include "support/api_fixture.h"

namespace paradesc::test {
namespace {

// Bent along one axis and sheared, so that no unit that goes with the size of the mesh hides it.
void bend(TestMesh &mesh, double amount) {
  for (Vec3 &p : mesh.points)
    p = {p.x + amount * std::sin(2 * p.y), p.y + 0.5 * amount * p.z * p.z, p.z + 0.3 * amount * p.x * p.y};
  round_to_float(mesh);
}

class Stale : public ::testing::TestWithParam<int32_t> {
protected:
  void SetUp() override {
    std::string why_not;
    context = open_context(GetParam(), why_not);
    if (!context) GTEST_SKIP() << why_not;
    mesh = ellipsoid(1, 0.8, 0.6, {.vertices = 600});
    lay_out(mesh, {.charts = 6});
    kept = make_mesh(context.get(), mesh);
  }

  Results run(pdesc_mesh *created, const Settings &settings) {
    const pdesc_options options = options_of(settings);
    std::vector<const char *> requested;
    for (const std::string &name : names) requested.push_back(name.c_str());
    pdesc_field *field = nullptr;
    EXPECT_EQ(
        pdesc_compute(created, &options, requested.data(), static_cast<int32_t>(requested.size()), nullptr, nullptr, &field),
        PDESC_OK)
        << pdesc_last_error();
    const Field owner(field);
    return read_field(field, mesh.vertex_count, names);
  }

  // Bends the kept mesh a little more and compares it with one that was never anything else.
  void bend_and_compare(const Settings &settings, const char *what) {
    SCOPED_TRACE(what);
    const std::vector<float> before = run(kept.get(), settings)["mean_curvature"];
    bend(mesh, 0.2);
    ASSERT_EQ(pdesc_mesh_set_positions(kept.get(), mesh.positions.data(), mesh.vertex_count), PDESC_OK) << pdesc_last_error();
    const Results now = run(kept.get(), settings), fresh = run(make_mesh(context.get(), mesh).get(), settings);
    EXPECT_NE(now["mean_curvature"], before) << "the bend is to change something";
    for (const auto &[name, values] : fresh.values) expect_same_bits(now[name], values);
    EXPECT_EQ(now.mask, fresh.mask);
    EXPECT_EQ(now.report.radius, fresh.report.radius);
    EXPECT_EQ(now.report.radius_in_texels, fresh.report.radius_in_texels);
    EXPECT_EQ(now.report.covered_texels, fresh.report.covered_texels);
  }

  // Colors of a normal map that leans by `lean`, and tangents for it.
  void set_normal_map(pdesc_mesh *created, float lean) {
    std::vector<float> rgb, tangents;
    for (int pixel = 0; pixel < 64; ++pixel)
      for (const float value : {0.5f + lean * (pixel % 8 < 4 ? 1.0f : -1.0f), 0.5f + 0.5f * lean, 0.9f}) rgb.push_back(value);
    for (size_t corner = 0; corner < mesh.corner_vertices.size(); ++corner)
      for (const float value : {1.0f, 0.0f, 0.0f, 1.0f}) tangents.push_back(value);
    ASSERT_EQ(
        pdesc_mesh_set_normal_map(created, rgb.data(), 8, 8, tangents.data(), static_cast<int32_t>(mesh.corner_vertices.size())),
        PDESC_OK)
        << pdesc_last_error();
  }

  Context context;
  TestMesh mesh;
  Mesh kept;
  std::vector<std::string> names{"mean_curvature", "principal_direction_max", "euclidean_area", "sphere_volume", "harris"};
};
PDESC_ON_EACH_BACKEND(Stale);

TEST_P(Stale, a_bent_mesh_is_computed_as_a_new_one) {
  const Settings usual{.radius = 0.1, .samples = 64, .buffer_size = 256};
  bend_and_compare(usual, "as it is by default");
  const bool on_device = GetParam() == device_backend();
  if (!on_device) names.pop_back(); // the windows of an operator take the reference seconds each time
  const auto with = [&](auto &&change) {
    Settings settings = usual;
    change(settings);
    return settings;
  };
  bend_and_compare(with([](Settings &s) { s.normals = PDESC_NORMALS_MAX; }), "Max's normals");
  bend_and_compare(with([](Settings &s) { s.radius = 0.05; }), "another radius");
  bend_and_compare(with([](Settings &s) { s.distance = PDESC_DISTANCE_GEODESIC; }), "along the surface");
  bend_and_compare(with([](Settings &s) { s.estimator = PDESC_ESTIMATOR_INTEGRAL; }), "integrals");
  if (GetParam() == PDESC_BACKEND_CPU)
    bend_and_compare(with([](Settings &s) {
                       s.evaluate = PDESC_EVALUATE_TEXEL;
                       s.texels = 64;
                     }),
                     "at texels");
  if (!on_device) return; // the rest is of texture space
  bend_and_compare(with([](Settings &s) { s.precision = PDESC_PRECISION_HALF; }), "half floats");
  names.pop_back(); // operators work at vertices, and the paper's way is slow
  bend_and_compare(with([](Settings &s) { s.relocation = PDESC_RELOCATION_PAPER; }), "the paper's way");
  bend_and_compare(with([](Settings &s) {
                     s.evaluate = PDESC_EVALUATE_TEXEL;
                     s.texels = 64;
                   }),
                   "at texels");
}

// A sheet that is folded where it lies: balls of the same radius then hold more pieces of it than before.
TEST_P(Stale, a_folded_sheet_is_computed_as_a_new_one) {
  constexpr double fold = 0.1;
  TestMesh sheet = plane(1, 1, {.vertices = 3000});
  lay_out(sheet, {.charts = 1});
  mesh = sheet;
  kept = make_mesh(context.get(), mesh);
  names = {"mean_curvature", "euclidean_area"};
  const Settings settings{.radius = 0.1, .radius_unit = PDESC_RADIUS_ABSOLUTE, .samples = 64, .buffer_size = 256};
  const std::vector<float> flat = run(kept.get(), settings)["euclidean_area"];
  for (const double slope : {0.5, 0.9}) {
    for (size_t i = 0; i < mesh.points.size(); ++i) {
      const double turns = sheet.points[i].x / fold, part = turns - std::floor(turns), up = part < 0.5 ? part : 1 - part;
      mesh.points[i].z = slope * fold * up;
    }
    round_to_float(mesh);
    ASSERT_EQ(pdesc_mesh_set_positions(kept.get(), mesh.positions.data(), mesh.vertex_count), PDESC_OK) << pdesc_last_error();
    const Results now = run(kept.get(), settings), fresh = run(make_mesh(context.get(), mesh).get(), settings);
    EXPECT_NE(now["euclidean_area"], flat) << "the folds are to change something";
    for (const std::string &name : names) expect_same_bits(now[name], fresh[name]);
  }
}

// A sheet of squares that is bent along one of their lines, then along another: as many creases, elsewhere.
TEST_P(Stale, creases_that_have_wandered_are_those_of_a_new_mesh) {
  TestMesh sheet = plane(1, 1, {.vertices = 441, .irregular = false});
  lay_out(sheet, {.charts = 1});
  std::set<double> columns;
  for (const Vec3 &point : sheet.points) columns.insert(point.x);
  ASSERT_GT(columns.size(), 15u);
  mesh = sheet;
  kept = make_mesh(context.get(), mesh);
  names = {"mean_curvature"};
  const Settings settings{.radius = 0.1, .radius_unit = PDESC_RADIUS_ABSOLUTE, .samples = 64, .buffer_size = 256};
  for (const int column : {5, 14}) {
    const double line = *std::next(columns.begin(), column);
    for (size_t i = 0; i < mesh.points.size(); ++i) mesh.points[i].z = std::max(0.0, sheet.points[i].x - line);
    round_to_float(mesh);
    ASSERT_EQ(pdesc_mesh_set_positions(kept.get(), mesh.positions.data(), mesh.vertex_count), PDESC_OK) << pdesc_last_error();
    const Results now = run(kept.get(), settings), fresh = run(make_mesh(context.get(), mesh).get(), settings);
    EXPECT_GT(now.report.crease_edges, 15);
    EXPECT_EQ(now.report.crease_edges, fresh.report.crease_edges);
    expect_same_bits(now["mean_curvature"], fresh["mean_curvature"]);
  }
}

TEST_P(Stale, a_normal_map_set_after_a_computation_counts) {
  if (GetParam() == PDESC_BACKEND_REFERENCE) names.pop_back(); // whose windows take it seconds each time
  const Settings settings{.radius = 0.1, .samples = 64, .buffer_size = 256};
  std::vector<float> last = run(kept.get(), settings)["mean_curvature"];
  for (const float lean : {0.2f, 0.1f}) {
    const Mesh fresh = make_mesh(context.get(), mesh);
    set_normal_map(kept.get(), lean);
    set_normal_map(fresh.get(), lean);
    const Results now = run(kept.get(), settings), expected = run(fresh.get(), settings);
    for (const std::string &name : names) expect_same_bits(now[name], expected[name]);
    EXPECT_NE(now["mean_curvature"], last) << "the map is to change something";
    last = now["mean_curvature"];
  }
}

TEST_P(Stale, what_is_displaced_follows_the_positions_the_normals_the_radius_and_the_size_of_the_image) {
  if (GetParam() == PDESC_BACKEND_REFERENCE) names.pop_back();
  Settings settings{.radius = 0.1, .samples = 64, .buffer_size = 256};
  std::vector<float> heights;
  for (int pixel = 0; pixel < 48 * 48; ++pixel) heights.push_back(0.1f * static_cast<float>(pixel % 7));
  int width = 48;
  std::vector<float> last;
  const auto step = [&](const char *what) {
    SCOPED_TRACE(what);
    const Mesh fresh = make_mesh(context.get(), mesh);
    for (pdesc_mesh *each : {kept.get(), fresh.get()})
      ASSERT_EQ(pdesc_mesh_set_displacement(each, heights.data(), width, 48 * 48 / width, 0.3, 0.05), PDESC_OK);
    const Results now = run(kept.get(), settings), expected = run(fresh.get(), settings);
    for (const std::string &name : names) expect_same_bits(now[name], expected[name]);
    EXPECT_NE(now["mean_curvature"], last) << "it is to change something";
    last = now["mean_curvature"];
  };
  step("at first");
  bend(mesh, 0.2);
  ASSERT_EQ(pdesc_mesh_set_positions(kept.get(), mesh.positions.data(), mesh.vertex_count), PDESC_OK) << pdesc_last_error();
  step("bent");
  settings.radius = 0.07;
  step("another radius");
  settings.normals = PDESC_NORMALS_MAX;
  step("other normals");
  width = 24;
  step("another size");
}

TEST_P(Stale, other_normals_count_where_nothing_else_changes) {
  if (GetParam() == PDESC_BACKEND_REFERENCE) names.pop_back(); // whose windows take it seconds each time
  Settings settings{.radius = 0.1, .samples = 64, .buffer_size = 256};
  std::vector<float> last = run(kept.get(), settings)["mean_curvature"];
  for (const int32_t kind : {PDESC_NORMALS_MAX, PDESC_NORMALS_MESH, PDESC_NORMALS_FITTED}) {
    settings.normals = kind;
    const Results now = run(kept.get(), settings), fresh = run(make_mesh(context.get(), mesh).get(), settings);
    for (const std::string &name : names) expect_same_bits(now[name], fresh[name]);
    EXPECT_NE(now["mean_curvature"], last) << "normals of kind " << kind << " are to change something";
    last = now["mean_curvature"];
  }
}

TEST_P(Stale, a_displacement_set_after_a_computation_counts) {
  if (GetParam() == PDESC_BACKEND_REFERENCE) names.pop_back(); // whose windows take it seconds each time
  const Settings settings{.radius = 0.1, .samples = 64, .buffer_size = 256};
  std::vector<float> last = run(kept.get(), settings)["mean_curvature"];
  for (const double scale : {0.1, 0.2}) {
    const Mesh fresh = make_mesh(context.get(), mesh);
    const float heights[] = {0.0f, 1.0f, 0.5f, 0.25f};
    for (pdesc_mesh *each : {kept.get(), fresh.get()})
      ASSERT_EQ(pdesc_mesh_set_displacement(each, heights, 2, 2, 0.5, scale), PDESC_OK) << pdesc_last_error();
    const Results now = run(kept.get(), settings), expected = run(fresh.get(), settings);
    for (const std::string &name : names) expect_same_bits(now[name], expected[name]);
    EXPECT_NE(now["mean_curvature"], last) << "the map is to change something";
    last = now["mean_curvature"];
  }
}

} // namespace
} // namespace paradesc::test
