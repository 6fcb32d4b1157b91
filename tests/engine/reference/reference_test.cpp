// The oracle against closed forms and what the definitions demand, and its manners.
//
// Each descriptor has a test of its own beside this one; here the oracle is asked directly, without the C interface.
#include "engine/reference/reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "descriptor/registry.h"
#include "support/error.h"
#include "support/percent_ae.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

struct Subject {
  Triangles triangles;
  HalfEdges half_edges;
  Normals normals;

  Subject(Triangles list, int32_t kind) : triangles(std::move(list)), half_edges(build_half_edges(triangles)) {
    normals = compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges), kind, 0);
  }
  explicit Subject(const TestMesh &mesh, int32_t kind = PDESC_NORMALS_MESH) : Subject(read_triangles(input_of(mesh)), kind) {}
};

struct Values {
  std::vector<std::vector<float>> columns; // as the names asked for, (vertex_count) each
  std::vector<uint8_t> boundary;
};

Values measure(const Subject &subject, double radius, const std::vector<const char *> &names, int threads = 0) {
  std::vector<int> rows;
  for (const char *name : names) rows.push_back(find_descriptor(name));
  const ReferenceField field =
      compute_reference(subject.triangles, subject.half_edges, subject.normals, {radius}, rows, threads, nullptr);
  Values values;
  values.columns.resize(names.size());
  for (const int32_t point : subject.half_edges.vertex_point) {
    for (size_t i = 0; i < names.size(); ++i) values.columns[i].push_back(field.values[i][static_cast<size_t>(point)]);
    values.boundary.push_back(field.boundary[static_cast<size_t>(point)]);
  }
  return values;
}

double longest_edge(const Triangles &triangles) {
  double longest = 0;
  for (int c = 0; c < 3 * triangles.triangle_count; ++c) {
    const auto p = [&](int corner) {
      return triangles.positions[static_cast<size_t>(triangles.corner_vertex[static_cast<size_t>(corner)])];
    };
    longest = std::max(longest, static_cast<double>(glm::length(p(next_corner(c)) - p(c))));
  }
  return longest;
}

void expect_each_near(std::span<const float> values, double expected, double tolerance) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  EXPECT_NEAR(*low, expected, tolerance);
  EXPECT_NEAR(*high, expected, tolerance);
}

Triangles square(vec3 origin = vec3(0)) {
  return shape({origin, origin + vec3(1, 0, 0), origin + vec3(1, 1, 0), origin + vec3(0, 1, 0)}, {0, 1, 2, 0, 2, 3});
}

// ---- Closed forms -----------------------------------------------------------------------------------------------------------

TEST(Reference, sphere_has_its_values_at_each_radius) {
  // Facets of edge e lie up to e²/(2R) below a sphere (circumradius at most e); values that would be exact on it, with exact
  // normals, are off by that share of R or of r.
  constexpr double R = 2;
  const Subject subject(sphere(R, {.vertices = 8000}));
  const double e = longest_edge(subject.triangles), relative = e * e / (2 * R * R);
  for (const double r : {0.1, 0.2, 0.5}) {
    const Values values =
        measure(subject, r, {"mean_curvature", "gaussian_curvature", "local_bending_energy", "sphere_volume", "euclidean_area"});
    const double lens = 2 * pi * r * r * r / 3 - pi * std::pow(r, 4) / (4 * R);
    expect_each_near(values.columns[0], 1 / R, relative / R);
    expect_each_near(values.columns[1], 1 / (R * R), 2 * relative / (R * R));
    expect_each_near(values.columns[2], 1 / (R * R), 2 * relative / (R * R));
    expect_each_near(values.columns[3], lens, pi * r * r * e * e / (2 * R));
    expect_each_near(values.columns[4], pi * r * r, pi * r * r * 2 * relative); // a cap of chord r has the disk's area
  }
}

TEST(Reference, plane_is_exact_over_interior_vertices) {
  constexpr double r = 0.11;
  const TestMesh mesh = plane(1, 1, {.vertices = 3000});
  const Values values = measure(Subject(mesh), r,
                                {"mean_curvature", "gaussian_curvature", "local_bending_energy", "sphere_volume",
                                 "sphere_volume_normalized", "euclidean_area", "shape_index"});
  const std::vector<uint8_t> inside = interior(mesh, r);
  for (size_t v = 0; v < inside.size(); ++v) {
    EXPECT_TRUE(std::isnan(values.columns[6][v]));
    EXPECT_EQ(values.columns[0][v], 0);
    EXPECT_EQ(values.columns[1][v], 0);
    EXPECT_EQ(values.columns[2][v], 0);
    if (!inside[v]) continue;
    EXPECT_NEAR(values.columns[3][v], 2 * pi * r * r * r / 3, 1e-7 * r * r * r); // float results
    EXPECT_NEAR(values.columns[4][v], 0.5, 1e-7);
    EXPECT_NEAR(values.columns[5][v], pi * r * r, 1e-7 * pi * r * r);
  }
}

TEST(Reference, cylinder_has_its_values_over_interior_vertices) {
  // In the tangent plane d is (R sin, z) and n_i - n is (sin, 0): the shape operator is exact at every r. Facets as on the
  // sphere.
  constexpr double R = 1, r = 0.1;
  const TestMesh mesh = cylinder(R, 1, {.vertices = 6000});
  const Subject subject(mesh);
  const Values values =
      measure(subject, r, {"mean_curvature", "principal_curvature_max", "principal_curvature_min", "shape_index"});
  const double e = longest_edge(subject.triangles), tolerance = e * e / (2 * R * R);
  const std::vector<uint8_t> inside = interior(mesh, r);
  for (size_t v = 0; v < inside.size(); ++v) {
    if (!inside[v]) continue;
    EXPECT_NEAR(values.columns[0][v], 1 / (2 * R), tolerance);
    EXPECT_NEAR(values.columns[1][v], 1 / R, tolerance);
    EXPECT_NEAR(values.columns[2][v], 0, tolerance);
    EXPECT_NEAR(values.columns[3][v], 0.5, tolerance);
  }
}

// Half a turn about the y axis lays the saddle z = xy upside down on itself, diagonals too: all that has a sign is zero.
TEST(Reference, saddle_point_is_neither_convex_nor_concave) {
  constexpr int n = 20;
  std::vector<vec3> positions;
  std::vector<int32_t> corners;
  for (int j = -n; j <= n; ++j)
    for (int i = -n; i <= n; ++i) positions.push_back(vec3(i, j, static_cast<float>(i * j) / n) / float{n});
  for (int32_t j = 0; j < 2 * n; ++j)
    for (int32_t i = 0; i < 2 * n; ++i) {
      const int32_t p = j * (2 * n + 1) + i, q = p + 1, s = p + 2 * n + 1, r = s + 1;
      if (i < n)
        corners.insert(corners.end(), {p, q, r, p, r, s});
      else
        corners.insert(corners.end(), {p, q, s, q, r, s});
    }
  const Values values = measure(Subject(shape(positions, corners), PDESC_NORMALS_FITTED), 0.3,
                                {"sphere_volume_normalized", "shape_index", "mean_curvature", "gaussian_curvature"});
  constexpr size_t center = n * (2 * n + 1) + n;
  EXPECT_NEAR(values.columns[0][center], 0.5, 1e-6); // float positions and normals
  EXPECT_NEAR(values.columns[1][center], 0, 1e-6);
  EXPECT_NEAR(values.columns[2][center], 0, 1e-6);
  // n_i - n is (-y, -x)/sqrt(1 + x² + y²) in the tangent plane: less than linear, by the mean of (x² + y²)/2, at most r²/2.
  EXPECT_LT(values.columns[3][center], -1 + 0.3 * 0.3);
  EXPECT_GT(values.columns[3][center], -1);
}

// The project's bound for the whole chain of fitted normals and shape operator: mean %AE against exact values.
TEST(Reference, irregular_surfaces_have_their_curvatures_within_a_quarter_of_a_percent) {
  const TestMesh meshes[] = {torus(1, 0.4, {.vertices = 15000}), ellipsoid(1.5, 1, 0.7, {.vertices = 22000})};
  for (const TestMesh &mesh : meshes) {
    const Subject subject(mesh, PDESC_NORMALS_FITTED);
    for (const double fraction : {0.01, 0.02}) {
      const Values values = measure(subject, fraction * mesh.diagonal(), {"mean_curvature", "gaussian_curvature"});
      EXPECT_LT(percent_ae(values.columns[0], mesh.H).mean, 0.25) << fraction;
      EXPECT_LT(percent_ae(values.columns[1], mesh.K).mean, 0.25) << fraction;
    }
  }
}

TEST(Reference, bending_tends_to_the_mean_square_of_curvature) {
  // Its bias is of the neighborhood's second order: halving r leaves a quarter. Exact normals, fine mesh; the facets' share of
  // the error does not shrink with r, hence 3.
  const TestMesh mesh = ellipsoid(1.5, 1, 0.7, {.vertices = 12000});
  std::vector<double> limit;
  for (size_t v = 0; v < mesh.k1.size(); ++v) limit.push_back((mesh.k1[v] * mesh.k1[v] + mesh.k2[v] * mesh.k2[v]) / 2);
  const Subject subject(mesh);
  const auto error = [&](double r) { return percent_ae(measure(subject, r, {"local_bending_energy"}).columns[0], limit).mean; };
  const double wide = error(0.16), narrow = error(0.08);
  EXPECT_GT(wide, 3 * narrow);
  EXPECT_LT(narrow, 0.25);
}

// ---- What the definitions demand --------------------------------------------------------------------------------------------

TEST(Reference, corner_of_a_square_sees_a_quarter_of_the_disk) {
  const Values values = measure(Subject(square(), PDESC_NORMALS_MAX), 0.5, {"euclidean_area", "mean_curvature"});
  for (const float area : values.columns[0]) EXPECT_NEAR(area, pi * 0.25 / 4, 1e-7); // float results
  for (const float H : values.columns[1]) EXPECT_EQ(H, 0);
}

TEST(Reference, ball_around_everything_sees_everything) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 500});
  const Values values = measure(Subject(mesh), 3, {"euclidean_area"});
  double area = 0;
  for (size_t c = 0; c < mesh.corner_vertices.size(); c += 3) {
    const auto p = [&](size_t k) {
      const size_t v = 3 * static_cast<size_t>(mesh.corner_vertices[c + k]);
      return Vec3{mesh.positions[v], mesh.positions[v + 1], mesh.positions[v + 2]};
    };
    area += length(cross(p(1) - p(0), p(2) - p(0))) / 2;
  }
  expect_each_near(values.columns[0], area, 2e-7 * area); // float results
}

// The ball around the middle of a prism's cap just meets the sides. Beyond r along the surface lies no more of a side than what
// the ball cuts out of it.
TEST(Reference, no_more_than_the_area_in_the_ball_lies_beyond_the_radius_along_the_surface) {
  constexpr int sides = 24;
  const Subject subject(prism(sides), PDESC_NORMALS_MAX);
  const auto &positions = subject.triangles.positions;
  const auto middle = static_cast<size_t>(std::ranges::find(positions, vec3(0, 0, 1)) - positions.begin());
  ASSERT_LT(middle, positions.size());
  const Values values = measure(subject, 1.0002 * std::cos(pi / sides), {"geodesic_area", "euclidean_area"});
  // Normals turn towards the rim, so the strip there takes 2 % of the area. It took a fifth.
  EXPECT_NEAR(values.columns[0][middle] / values.columns[1][middle], 0.98f, 0.01f);
}

TEST(Reference, only_the_connected_sheet_counts) {
  constexpr double r = 0.2;
  const TestMesh mesh = plane(1, 1, {.vertices = 2000});
  Triangles two = read_triangles(input_of(mesh));
  const auto positions = two.positions;
  for (const vec3 p : positions) two.positions.push_back(p + vec3(0, 0, 0.02f)); // a tenth of r above
  const auto corners = two.corner_vertex;
  for (const int32_t vertex : corners) two.corner_vertex.push_back(vertex + mesh.vertex_count);
  two = shape(two.positions, two.corner_vertex);
  const std::vector<const char *> names{"euclidean_area", "sphere_volume_normalized", "local_bending_energy"};
  const Values one = measure(Subject(mesh, PDESC_NORMALS_MAX), r, names),
               both = measure(Subject(two, PDESC_NORMALS_MAX), r, names);
  for (size_t i = 0; i < names.size(); ++i)
    for (size_t v = 0; v < one.columns[i].size(); ++v) EXPECT_EQ(both.columns[i][v], one.columns[i][v]);
}

TEST(Reference, surface_that_leaves_the_ball_and_returns_does_not_count) {
  // A strip folded into a U: its far arm comes within r of the near one, but the way around is longer than r.
  std::vector<vec3> positions;
  std::vector<int32_t> corners;
  const vec3 path[] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 0, 0.3f}, {1, 0, 0.3f}, {0, 0, 0.3f}};
  for (const vec3 p : path) {
    positions.push_back(p);
    positions.push_back(p + vec3(0, 1, 0));
  }
  for (int32_t i = 0; i < 5; ++i) corners.insert(corners.end(), {2 * i, 2 * i + 2, 2 * i + 3, 2 * i, 2 * i + 3, 2 * i + 1});
  const Values values = measure(Subject(shape(positions, corners), PDESC_NORMALS_MAX), 0.5, {"euclidean_area"});
  EXPECT_NEAR(values.columns[0][0], pi * 0.25 / 4, 1e-7); // at its end: a quarter of the disk
  EXPECT_NEAR(values.columns[0][2], pi * 0.25 / 2, 1e-7); // a step on: half of it
  EXPECT_GT(values.columns[0][4], pi * 0.25 / 4 + 0.1);   // at the fold both arms are connected within the ball
}

TEST(Reference, boundary_is_flagged_where_the_ball_reaches_it) {
  constexpr double r = 0.1;
  const TestMesh mesh = plane(1, 1, {.vertices = 2000});
  const Values values = measure(Subject(mesh), r, {"euclidean_area"});
  for (size_t v = 0; v < mesh.points.size(); ++v) {
    const double distance = 0.5 - std::max(std::abs(mesh.points[v].x), std::abs(mesh.points[v].y));
    if (std::abs(distance - r) < 1e-6) continue; // rounding decides
    EXPECT_EQ(values.boundary[v], distance < r) << distance;
  }
  for (const uint8_t flag : measure(Subject(sphere(1, {.vertices = 500})), 0.3, {"euclidean_area"}).boundary) EXPECT_EQ(flag, 0);
}

TEST(Reference, scaling_with_the_radius_scales_the_results) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  std::vector<const char *> names;
  for (const DescriptorRow &row : descriptors())
    if (row.map_degree == 0) names.push_back(row.name);
  const Values expected = measure(Subject(mesh), 0.15, names);
  for (const double factor : {0x1p-30, 0x1p20}) { // powers of two: float positions scale exactly
    TestMesh scaled = mesh;
    scale(scaled, factor);
    const Values found = measure(Subject(scaled), factor * 0.15, names);
    for (size_t i = 0; i < names.size(); ++i)
      for (size_t v = 0; v < mesh.points.size(); ++v) {
        const double value = expected.columns[i][v] * std::pow(factor, descriptors()[i].length_power);
        if (std::isnan(value) && std::isnan(found.columns[i][v])) continue; // the standard error, by normals that were given
        ASSERT_NEAR(found.columns[i][v], value, 1e-5 * std::abs(value)) << names[i]; // rounding against the plane threshold aside
      }
  }
}

TEST(Reference, turning_the_winding_over_turns_the_signs) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  Triangles turned = read_triangles(input_of(mesh));
  for (size_t c = 0; c < turned.corner_vertex.size(); c += 3) std::swap(turned.corner_vertex[c + 1], turned.corner_vertex[c + 2]);
  const std::vector<const char *> names{"mean_curvature", "gaussian_curvature", "sphere_volume_normalized", "shape_index"};
  const Values out = measure(Subject(mesh, PDESC_NORMALS_MAX), 0.15, names);
  const Values in = measure(Subject(turned, PDESC_NORMALS_MAX), 0.15, names);
  for (size_t v = 0; v < mesh.points.size(); ++v) { // other orders of sums: float rounding of values near 1
    ASSERT_NEAR(in.columns[0][v], -out.columns[0][v], 1e-5);
    ASSERT_NEAR(in.columns[1][v], out.columns[1][v], 1e-5 * (1 + std::abs(out.columns[1][v])));
    ASSERT_NEAR(in.columns[2][v], 1 - out.columns[2][v], 1e-6);
    ASSERT_NEAR(in.columns[3][v], -out.columns[3][v], 1e-5);
  }
}

// ---- Quadrature; more in reference_quadrature_test.cpp ----------------------------------------------------------------------

// The rules chosen by nearness against twelve points everywhere would cost ten times as much and move nothing: instead the same
// surface is measured again with every triangle cut into four, which are nearer to their size, with finer rules.
TEST(ReferenceQuadrature, refining_flat_facets_changes_nothing) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 1500});
  const Subject coarse(mesh);
  std::vector<vec3> positions = coarse.triangles.positions;
  std::vector<int32_t> corners;
  std::vector<vec3> normals;
  for (size_t c = 0; c < coarse.triangles.corner_vertex.size(); c += 3) {
    int32_t vertex[6];
    vec3 normal[6];
    for (size_t k = 0; k < 3; ++k) {
      const size_t a = c + k, b = c + (k + 1) % 3;
      vertex[k] = coarse.triangles.corner_vertex[a];
      normal[k] = coarse.normals.corner(a);
      const auto end = static_cast<size_t>(coarse.triangles.corner_vertex[b]);
      vertex[3 + k] = static_cast<int32_t>(positions.size()); // welded by position
      positions.push_back(0.5f * (positions[static_cast<size_t>(vertex[k])] + positions[end]));
      normal[3 + k] = 0.5f * (coarse.normals.corner(a) + coarse.normals.corner(b));
    }
    for (const int k : {0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5}) {
      corners.push_back(vertex[k]);
      normals.push_back(normal[k]); // not normalized: linear over the coarse facet
    }
  }
  Subject fine(shape(positions, corners), PDESC_NORMALS_MAX);
  fine.normals.group = normals;
  fine.normals.corner_fan = nullptr;
  for (size_t v = 0; v < mesh.points.size(); ++v)
    fine.normals.point[static_cast<size_t>(fine.half_edges.vertex_point[v])] =
        coarse.normals.point[static_cast<size_t>(coarse.half_edges.vertex_point[v])];
  const std::vector<const char *> names{"mean_curvature", "gaussian_curvature", "local_bending_energy",
                                        "sphere_volume_normalized", "euclidean_area"};
  const double tolerances[] = {1e-5, 1e-5, 3e-4, 1e-6, 1e-5}; // 1/rho² varies fastest; midpoints are rounded to float
  for (const double r : {0.05, 0.2}) {
    const Values a = measure(coarse, r, names), b = measure(fine, r, names);
    for (size_t i = 0; i < names.size(); ++i) {
      const auto [low, high] = std::minmax_element(a.columns[i].begin(), a.columns[i].end());
      const double scale = std::max(std::abs(*low), std::abs(*high));
      for (size_t v = 0; v < mesh.points.size(); ++v)
        ASSERT_NEAR(a.columns[i][v], b.columns[i][v], tolerances[i] * scale) << names[i] << " at " << v << ", r " << r;
    }
  }
}

// ---- Manners ----------------------------------------------------------------------------------------------------------------

TEST(Reference, does_not_depend_on_the_number_of_threads) {
  const Subject subject(torus(1, 0.4, {.vertices = 2000}), PDESC_NORMALS_FITTED);
  std::vector<const char *> names;
  for (const DescriptorRow &row : descriptors())
    if (row.map_degree == 0) names.push_back(row.name);
  const Values one = measure(subject, 0.2, names, 1), five = measure(subject, 0.2, names, 5);
  EXPECT_EQ(one.boundary, five.boundary);
  for (size_t i = 0; i < names.size(); ++i) EXPECT_EQ(one.columns[i], five.columns[i]) << names[i];
}

TEST(Reference, asks_no_more_after_it_was_told_to_stop) {
  const Subject subject(torus(1, 0.4, {.vertices = 24000}), PDESC_NORMALS_MAX);
  const std::vector<int> rows{0};
  int calls = 0;
  const auto refuse_the_third = [&](double fraction) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    if (++calls == 3) throw Error(PDESC_ERROR_CANCELLED, "Told to stop.");
  };
  try {
    compute_reference(subject.triangles, subject.half_edges, subject.normals, {0.3}, rows, 2, refuse_the_third);
    FAIL() << "it went on";
  } catch (const Error &error) {
    EXPECT_EQ(error.status(), PDESC_ERROR_CANCELLED);
  }
  EXPECT_EQ(calls, 3);
}

TEST(Reference, descriptors_of_an_empty_neighborhood_are_undefined) {
  ReferenceNeighborhood nothing;
  nothing.radius = 1;
  nothing.k1 = nothing.k2 = nothing.mean = nothing.gauss = std::numeric_limits<double>::quiet_NaN();
  nothing.direction_max = nothing.direction_min = dvec3(std::numeric_limits<double>::quiet_NaN());
  const auto undefined = [](auto value) {
    if constexpr (std::is_same_v<decltype(value), dvec3>)
      return std::isnan(value.x) && std::isnan(value.y) && std::isnan(value.z);
    else
      return std::isnan(value);
  };
#define DESCRIPTOR(name, ...) EXPECT_TRUE(undefined(reference_##name(nothing))) << #name;
#include "descriptor/descriptors.def"
#undef DESCRIPTOR
#define OPERATOR(name, ...) EXPECT_TRUE(undefined(reference_##name(nothing))) << #name;
#include "descriptor/operators.def"
#undef OPERATOR
}

TEST(Reference, mesh_without_faces_has_no_values) {
  const Subject subject(shape({{0, 0, 0}}, {}), PDESC_NORMALS_MAX);
  const std::vector<int> rows{0, 1};
  const ReferenceField field = compute_reference(subject.triangles, subject.half_edges, subject.normals, {1}, rows, 0, nullptr);
  EXPECT_EQ(field.values.size(), 2u);
  EXPECT_TRUE(field.values[0].empty());
}

} // namespace
} // namespace paradesc::test
