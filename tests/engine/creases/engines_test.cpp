// A box through the C interface: every engine measures its edges alike, at vertices and at texels.
#include <algorithm>
#include <array>
#include <cmath>

#include "support/api_fixture.h"
#include "support/solids.h"

namespace paradesc::test {
namespace {

constexpr int cells = 20;
constexpr double radius = 0.3;

TestMesh without_uvs(const Triangles &triangles) {
  TestMesh mesh;
  mesh.vertex_count = triangles.vertex_count;
  for (const vec3 &p : triangles.positions) {
    mesh.positions.insert(mesh.positions.end(), {p.x, p.y, p.z});
    mesh.points.push_back({p.x, p.y, p.z});
  }
  mesh.corner_vertices = triangles.corner_vertex;
  for (size_t c = 0; c < triangles.corner_vertex.size(); ++c) mesh.triangle_corners.push_back(static_cast<int32_t>(c));
  return mesh;
}

// Each side is a chart of its own.
TestMesh box_with_uvs() {
  const Triangles triangles = box(cells);
  TestMesh mesh = without_uvs(triangles);
  for (size_t c = 0; c < triangles.corner_vertex.size(); ++c) {
    const size_t side = c / (6 * cells * cells);
    const vec3 p = triangles.position(static_cast<int>(c));
    const float x = 0.5f + 0.48f * p[static_cast<int>(side / 2 + 1) % 3],
                y = 0.5f + 0.48f * p[static_cast<int>(side / 2 + 2) % 3];
    // The other side is seen from behind.
    mesh.corner_uvs.push_back((static_cast<float>(side / 2) + (side % 2 ? 1 - x : x)) / 3);
    mesh.corner_uvs.push_back((static_cast<float>(side % 2) + y) / 3);
  }
  return mesh;
}

double beside_edge(double t) { return t < 1 ? 2.0 / 3 * (1 - t) * (1 - t) * (2 + t) : 0; }

class CreasesOn : public ::testing::TestWithParam<int32_t> {
protected:
  void SetUp() override {
    std::string why_not;
    context = open_context(GetParam(), why_not);
    if (!context) GTEST_SKIP() << why_not;
    pdesc_options_init(&options);
    options.radius = radius;
    options.radius_unit = PDESC_RADIUS_ABSOLUTE;
  }

  Field compute(pdesc_mesh *subject) {
    const std::array<const char *, 3> names = {"mean_curvature", "sphere_volume_normalized", "geodesic_area"};
    pdesc_field *field = nullptr;
    EXPECT_EQ(pdesc_compute(subject, &options, names.data(), static_cast<int32_t>(names.size()), nullptr, nullptr, &field),
              PDESC_OK)
        << pdesc_last_error();
    return Field(field);
  }

  std::vector<float> values(const pdesc_field *field, const char *name) const {
    std::vector<float> found(static_cast<size_t>(mesh.vertex_count), sentinel);
    EXPECT_EQ(pdesc_field_values(field, name, found.data(), mesh.vertex_count), PDESC_OK) << pdesc_last_error();
    return found;
  }

  // From the edges nearest, of a place.
  static std::array<double, 3> depths(Vec3 p) {
    std::array<double, 3> depth{1 - std::abs(p.x), 1 - std::abs(p.y), 1 - std::abs(p.z)};
    std::sort(depth.begin(), depth.end());
    return depth;
  }

  const TestMesh mesh = box_with_uvs();
  Context context;
  pdesc_options options{};
};

TEST_P(CreasesOn, edges_are_those_of_the_solid_at_vertices) {
  const Mesh created = make_mesh(context.get(), mesh);
  for (const int32_t estimator : {PDESC_ESTIMATOR_SHAPE_OPERATOR, PDESC_ESTIMATOR_INTEGRAL, PDESC_ESTIMATOR_EXTRAPOLATED}) {
    options.estimator = estimator;
    const Field field = compute(created.get());
    const std::vector<float> mean = values(field.get(), "mean_curvature"),
                             volume = values(field.get(), "sphere_volume_normalized");
    for (size_t v = 0; v < mean.size(); ++v) {
      const std::array<double, 3> depth = depths(mesh.points[v]);
      if (depth[1] < radius && depth[2] < radius && depth[2] > 1e-6) continue; // two edges
      const double want = depth[2] < 1e-6 ? 2 : beside_edge(depth[1] / radius);
      ASSERT_NEAR(mean[v] * radius, want, 2e-3) << estimator << " at " << depth[1];
      ASSERT_NEAR(volume[v], 0.5 - 3.0 / 16 * want, 1e-3);
    }
    pdesc_field_report report;
    pdesc_field_report_init(&report);
    ASSERT_EQ(pdesc_field_get_report(field.get(), &report), PDESC_OK);
    EXPECT_EQ(report.crease_edges, 12 * cells);
  }
}

TEST_P(CreasesOn, edges_are_those_of_the_solid_at_texels) {
  if (GetParam() == PDESC_BACKEND_REFERENCE) GTEST_SKIP() << "the reference has no texels";
  options.evaluate = PDESC_EVALUATE_TEXEL;
  options.texels = 300;
  const Mesh created = make_mesh(context.get(), mesh);
  const Field field = compute(created.get());
  const std::vector<float> mean = map_of(field.get(), "mean_curvature");
  int near = 0, far = 0;
  for (size_t i = 0; i < mean.size(); ++i) {
    if (std::isnan(mean[i])) continue;
    const auto along = [](double uv) { return 1 - std::abs((3 * uv - std::floor(3 * uv) - 0.5) / 0.48); };
    const double u = (static_cast<double>(i % 300) + 0.5) / 300, v = (static_cast<double>(i / 300) + 0.5) / 300;
    const double low = std::min(along(u), along(v)), high = std::max(along(u), along(v));
    if (high < radius) continue; // two edges
    ++(low < radius ? near : far);
    // From the middle of a texel at the seam to its own place it is up to half of a texel.
    ASSERT_NEAR(mean[i] * radius, beside_edge(std::max(low, 0.0) / radius), low < 0.02 ? 0.1 : 2e-3) << i;
  }
  EXPECT_GT(near, 10000);
  EXPECT_GT(far, 10000);
}

TEST_P(CreasesOn, a_descriptor_has_one_value_with_others_and_alone) {
  const Mesh created = make_mesh(context.get(), mesh);
  for (const int32_t estimator : {PDESC_ESTIMATOR_SHAPE_OPERATOR, PDESC_ESTIMATOR_INTEGRAL}) {
    options.estimator = estimator;
    const auto compute_all = [&](const std::vector<const char *> &names) {
      pdesc_field *field = nullptr;
      EXPECT_EQ(pdesc_compute(created.get(), &options, names.data(), static_cast<int32_t>(names.size()), nullptr, nullptr, &field),
                PDESC_OK)
          << pdesc_last_error();
      return values(Field(field).get(), "gaussian_curvature");
    };
    const std::vector<float> alone = compute_all({"gaussian_curvature"}),
                             beside = compute_all({"principal_direction_max", "gaussian_curvature", "principal_curvature_min"});
    for (size_t v = 0; v < alone.size(); ++v)
      ASSERT_NEAR(alone[v], beside[v], 1e-6f + 1e-6f * std::abs(alone[v])) << estimator << " at " << v;
  }
}

TEST_P(CreasesOn, none_rounds_them_and_marked_takes_marks) {
  const Mesh created = make_mesh(context.get(), mesh);
  const std::vector<float> hard = values(compute(created.get()).get(), "mean_curvature");
  options.creases = PDESC_CREASES_NONE;
  const std::vector<float> soft = values(compute(created.get()).get(), "mean_curvature");
  options.creases = PDESC_CREASES_MARKED; // none is
  EXPECT_EQ(values(compute(created.get()).get(), "mean_curvature"), soft);
  const auto most = [](const std::vector<float> &all) { return *std::max_element(all.begin(), all.end()); };
  EXPECT_LT(most(soft), 0.9 * most(hard));
  options.creases = PDESC_CREASES_AUTO; // nothing that was kept is of other normals
  EXPECT_EQ(values(compute(created.get()).get(), "mean_curvature"), hard);
  options.creases = PDESC_CREASES_NONE;
  const Mesh other = make_mesh(context.get(), mesh);
  EXPECT_EQ(values(compute(other.get()).get(), "mean_curvature"), soft);
}

PDESC_ON_EACH_BACKEND(CreasesOn);

// The blend takes nearly all of the time here, half a second of one core, and progress is told every few milliseconds.
TEST(CreasesOnCpu, have_progress_while_they_are_blended) {
  std::string why_not;
  const Context context = open_context(PDESC_BACKEND_CPU, why_not);
  const Mesh subject = make_mesh(context.get(), without_uvs(prism(300, 4)));
  pdesc_options options;
  pdesc_options_init(&options);
  options.radius = 1.5;
  options.radius_unit = PDESC_RADIUS_ABSOLUTE;
  const auto note = [](void *user, const char *, double fraction) {
    static_cast<std::vector<double> *>(user)->push_back(fraction);
    return int32_t{1};
  };
  std::vector<double> told;
  const char *name = "mean_curvature";
  pdesc_field *field = nullptr;
  ASSERT_EQ(pdesc_compute(subject.get(), &options, &name, 1, note, &told, &field), PDESC_OK) << pdesc_last_error();
  const Field owner(field);
  EXPECT_GT(std::ranges::count_if(told, [](double fraction) { return fraction > 0.55 && fraction < 0.95; }), 5);
}

} // namespace
} // namespace paradesc::test
