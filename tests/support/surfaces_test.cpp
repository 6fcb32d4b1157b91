// The tests' own surfaces and layouts, proven before anything is measured with them.
#include "support/surfaces.h"

#include <algorithm>
#include <array>
#include <map>

#include <gtest/gtest.h>

#include "support/layout.h"
#include "support/percent_ae.h"
#include "support/triangulation.h"

namespace paradesc::test {
namespace {

constexpr double pi = 3.14159265358979323846;

Vec3 corner_point(const TestMesh &mesh, int32_t t, int i) {
  return mesh.points[static_cast<size_t>(mesh.corner_vertices[static_cast<size_t>(3 * t + i)])];
}

struct Totals {
  double area = 0, K = 0, H = 0, least_agreement = 1;
};

// Integrals by the vertices' mean on each triangle, and the worst cosine between a face and its corners' exact normals.
Totals integrate(const TestMesh &mesh) {
  Totals totals;
  for (int32_t t = 0; t < mesh.triangle_count(); ++t) {
    const Vec3 n =
        cross(corner_point(mesh, t, 1) - corner_point(mesh, t, 0), corner_point(mesh, t, 2) - corner_point(mesh, t, 0));
    const double area = length(n) / 2;
    totals.area += area;
    for (int i = 0; i < 3; ++i) {
      const size_t v = static_cast<size_t>(mesh.corner_vertices[static_cast<size_t>(3 * t + i)]);
      totals.K += area / 3 * mesh.K[v];
      totals.H += area / 3 * mesh.H[v];
      totals.least_agreement = std::min(totals.least_agreement, dot(normalized(n), mesh.normals[v]));
    }
  }
  return totals;
}

struct UvTriangle {
  std::array<double, 2> a, b, c;
  double area() const { return ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2; }
};

UvTriangle uv_triangle(const TestMesh &mesh, int32_t t) {
  const float *uv = &mesh.corner_uvs[static_cast<size_t>(6 * t)];
  return {{uv[0], uv[1]}, {uv[2], uv[3]}, {uv[4], uv[5]}};
}

// Texel centers owned by more than one triangle. Strictly inside: neighbors share edges.
int overlapping_texels(const TestMesh &mesh, int size) {
  std::vector<uint8_t> owners(static_cast<size_t>(size * size), 0);
  for (int32_t t = 0; t < mesh.triangle_count(); ++t) {
    UvTriangle p = uv_triangle(mesh, t);
    const int low_x = static_cast<int>(size * std::min({p.a[0], p.b[0], p.c[0]}));
    const int low_y = static_cast<int>(size * std::min({p.a[1], p.b[1], p.c[1]}));
    const int high_x = static_cast<int>(size * std::max({p.a[0], p.b[0], p.c[0]}));
    const int high_y = static_cast<int>(size * std::max({p.a[1], p.b[1], p.c[1]}));
    const double sign = p.area() < 0 ? -1 : 1;
    for (int y = low_y; y <= high_y; ++y)
      for (int x = low_x; x <= high_x; ++x) {
        const std::array<double, 2> q{(x + 0.5) / size, (y + 0.5) / size};
        constexpr double inside = 1e-12;
        if (sign * UvTriangle{p.a, p.b, q}.area() > inside && sign * UvTriangle{p.b, p.c, q}.area() > inside &&
            sign * UvTriangle{p.c, p.a, q}.area() > inside)
          ++owners[static_cast<size_t>(y * size + x)];
      }
  }
  return static_cast<int>(std::count_if(owners.begin(), owners.end(), [](uint8_t n) { return n > 1; }));
}

// Charts as the library counts them: triangles joined by edges whose UVs agree.
int count_charts(const TestMesh &mesh) {
  std::vector<int32_t> parent(static_cast<size_t>(mesh.triangle_count()));
  for (size_t t = 0; t < parent.size(); ++t) parent[t] = static_cast<int32_t>(t);
  const auto root = [&](int32_t t) {
    while (parent[static_cast<size_t>(t)] != t) t = parent[static_cast<size_t>(t)];
    return t;
  };
  const auto uv_of = [&](int32_t t, int32_t vertex) {
    for (int i = 0; i < 3; ++i) {
      const size_t c = static_cast<size_t>(3 * t + i);
      if (mesh.corner_vertices[c] == vertex) return std::array{mesh.corner_uvs[2 * c], mesh.corner_uvs[2 * c + 1]};
    }
    return std::array{-1.0f, -1.0f};
  };
  int charts = mesh.triangle_count();
  for (const MeshEdge &edge : mesh_edges(mesh)) {
    if (edge.triangle_b < 0) continue;
    if (uv_of(edge.triangle_a, edge.low) != uv_of(edge.triangle_b, edge.low)) continue;
    if (uv_of(edge.triangle_a, edge.high) != uv_of(edge.triangle_b, edge.high)) continue;
    const int32_t a = root(edge.triangle_a), b = root(edge.triangle_b);
    if (a == b) continue;
    parent[static_cast<size_t>(a)] = b;
    --charts;
  }
  return charts;
}

void expect_sound_layout(const TestMesh &mesh, const Layout &layout) {
  SCOPED_TRACE("charts " + std::to_string(layout.charts) + ", offset " + std::to_string(layout.offset));
  EXPECT_EQ(count_charts(mesh), layout.charts);
  EXPECT_EQ(overlapping_texels(mesh, 512), 0);
  for (const float uv : mesh.corner_uvs) ASSERT_TRUE(uv > 0 && uv < 1) << uv;
  std::map<int32_t, int> orientation;
  for (int32_t t = 0; t < mesh.triangle_count(); ++t) {
    const int side = uv_triangle(mesh, t).area() > 0 ? 1 : -1;
    ASSERT_EQ(orientation.try_emplace(mesh.triangle_chart[static_cast<size_t>(t)], side).first->second, side) << "folded over";
  }
}

TEST(Surfaces, closed_surfaces_obey_gauss_bonnet) {
  // The vertex rule on 20 K triangles leaves about their squared size, 1e-3 of the whole.
  for (const bool irregular : {false, true}) {
    const Triangulation triangulation{.irregular = irregular};
    for (const TestMesh &mesh : {sphere(2, triangulation), ellipsoid(1, 0.75, 0.5, triangulation), goursat(0.5, triangulation)})
      EXPECT_NEAR(integrate(mesh).K, 4 * pi, 4 * pi * 2e-3);
    const TestMesh ring = torus(1, 0.4, triangulation);
    EXPECT_NEAR(integrate(ring).K, 0, 4 * pi * 2e-3);
    EXPECT_NEAR(integrate(ring).H, 4 * pi * pi * 1 / 2, 4 * pi * pi * 1e-3); // the integral of H over a torus is 2 pi² R
  }
}

// A second opinion on H: the area's first variation, d area = 2 H d volume, moving every vertex along its exact normal.
TEST(Surfaces, mean_curvature_is_the_rate_of_area_along_the_normal) {
  for (const TestMesh &mesh : {sphere(2), ellipsoid(1, 0.75, 0.5), torus(1, 0.4), goursat(0.5), cylinder(0.5, 2), saddle(1),
                               catenoid(0.5, 0.6), plane(2, 1)}) {
    constexpr double step = 1e-4;
    TestMesh moved = mesh;
    for (size_t v = 0; v < moved.points.size(); ++v) moved.points[v] = moved.points[v] + step * moved.normals[v];
    const Totals before = integrate(mesh), after = integrate(moved);
    // Open surfaces keep no term at the border: their normals are at right angles to it. 1e-3: size of the triangles squared.
    EXPECT_NEAR((after.area - before.area) / step, 2 * before.H, 2e-3 * before.area * (1 + std::abs(before.H)));
    EXPECT_GT(before.least_agreement, 0.9) << "a face turned away from the surface";
  }
}

TEST(Surfaces, gaussian_curvature_of_open_surfaces_is_their_closed_form) {
  // Total curvature: of the catenoid -4 pi tanh(h/c); of the saddle over a square by its angle defect at the border, known as the
  // integral of -1/(1 + x² + y²)^(3/2), which is -4 atan(1/sqrt(3)) = -2 pi/3 over [-1, 1]².
  EXPECT_NEAR(integrate(catenoid(0.5, 0.6)).K, -4 * pi * std::tanh(1.2), 4 * pi * 2e-3);
  EXPECT_NEAR(integrate(saddle(1)).K, -2 * pi / 3, 2 * pi * 2e-3);
  EXPECT_EQ(integrate(cylinder(0.5, 2)).K, 0);
}

TEST(Surfaces, the_same_seed_gives_the_same_mesh) {
  EXPECT_EQ(torus(1, 0.4).positions, torus(1, 0.4).positions);
  EXPECT_NE(torus(1, 0.4).positions, torus(1, 0.4, {.seed = 2}).positions);
}

TEST(Layout, charts_are_connected_unfolded_and_apart) {
  for (const bool irregular : {true, false})
    for (const int charts : {1, 6, 15, 60})
      for (const double offset : {0.0, 0.3}) {
        const Layout layout{.charts = charts, .offset = offset, .anisotropy = 1.3, .warp = 0.2};
        for (TestMesh mesh : {ellipsoid(1, 0.75, 0.5, {.vertices = 6000, .irregular = irregular}),
                              torus(1, 0.4, {.vertices = 6000, .irregular = irregular}),
                              catenoid(0.5, 0.6, {.vertices = 3000, .irregular = irregular})}) {
          lay_out(mesh, layout);
          expect_sound_layout(mesh, layout);
        }
      }
}

TEST(Layout, splitting_at_seams_keeps_every_corner_where_it_was) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  lay_out(mesh, {.charts = 15});
  const SplitMesh split = split_at_seams(mesh);
  EXPECT_GT(split.mesh.vertex_count, mesh.vertex_count);
  EXPECT_EQ(split.mesh.corner_uvs, mesh.corner_uvs);
  for (size_t c = 0; c < mesh.corner_vertices.size(); ++c)
    ASSERT_EQ(split.origin[static_cast<size_t>(split.mesh.corner_vertices[c])], mesh.corner_vertices[c]);
}

TEST(PercentAe, divides_by_the_range_of_the_reference) {
  std::vector<double> reference;
  for (int i = 0; i <= 1000; ++i) reference.push_back(i);
  std::vector<float> values(reference.begin(), reference.end());
  values[3] += 9.5f;
  const PercentAe error = percent_ae(values, reference);
  EXPECT_DOUBLE_EQ(error.range, 950);
  EXPECT_DOUBLE_EQ(error.max, 1);
  EXPECT_NEAR(error.mean, 1.0 / 1001, 1e-15);
  EXPECT_EQ(error.median, 0);
}

TEST(PercentAe, counts_a_value_on_one_side_only_as_all_wrong) {
  const std::vector<double> reference{1, 2, NAN, NAN};
  const std::vector<float> values{1, NAN, NAN, 3};
  const PercentAe error = percent_ae(values, reference);
  EXPECT_EQ(error.count, 3);
  EXPECT_NEAR(error.mean, 200.0 / 3, 1e-12);
}

TEST(PercentAe, divides_by_the_magnitude_of_a_constant_and_by_the_scale_of_a_zero) {
  EXPECT_DOUBLE_EQ(percent_ae(std::vector<float>(9, 2.5f), std::vector<double>(9, 2.0)).mean, 25);
  EXPECT_DOUBLE_EQ(percent_ae(std::vector<float>(9, 2.5f), std::vector<double>(9, 0.0), {}, 50).mean, 5);
}

} // namespace
} // namespace paradesc::test
