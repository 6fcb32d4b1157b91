// Curvature beside creases against the closed forms of the solid's volume in the ball, and its ways from the smooth surface
// there.
#include "engine/creases/blend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "descriptor/registry.h"
#include "engine/reference/reference.h"
#include "support/creases.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

struct Subject {
  Triangles triangles;
  HalfEdges half_edges;
  Creases creases;
  Normals normals;

  explicit Subject(Triangles list)
      : triangles(std::move(list)), half_edges(build_half_edges(triangles)), creases(creases_of(triangles, half_edges)) {
    normals = compute_normals(triangles, half_edges, build_normal_rings(triangles, half_edges, creases), PDESC_NORMALS_FITTED, 0);
  }

  // (vertex_count)
  std::vector<double> values(const char *name, double radius, bool with_creases = true) const {
    const int row = find_descriptor(name);
    const SurfaceMaps maps;
    const Box box;
    Atlases atlases;
    const NormalsOnDemand made{.make = [&]() -> const Normals & { return normals; }};
    Surface surface{triangles, half_edges, made, with_creases ? &creases : nullptr, maps, box, atlases, 0};
    const Facets facets = find_facets(triangles, half_edges, normals, creases);
    surface.facets = [&]() -> const Facets & { return facets; };
    const CreaseBlend blend(surface, std::span(&row, 1), radius, PDESC_ESTIMATOR_SHAPE_OPERATOR, {});
    const std::vector<int> needed = blend.needed(std::span(&row, 1));
    CenterResults results = unknown_results(static_cast<size_t>(half_edges.point_count), {});
    results.values = compute_reference(triangles, half_edges, normals, {radius}, needed, 0, nullptr).values;
    blend.at_points(needed, results);
    std::vector<double> values;
    for (const int32_t point : half_edges.vertex_point) values.push_back(results.values[0][static_cast<size_t>(point)]);
    return values;
  }
};

// Distances of a point of the surface of [-1, 1]³ from its three nearest sides, the nearest first.
dvec3 depths(vec3 p) {
  std::array<double, 3> depth{1 - std::abs(double{p.x}), 1 - std::abs(double{p.y}), 1 - std::abs(double{p.z})};
  std::sort(depth.begin(), depth.end());
  return {depth[0], depth[1], depth[2]};
}

// H r on a face at the distance t r of one edge of 90 degrees: half of the cap that its other face cuts off is missing.
double beside_edge(double t) { return t < 1 ? 2.0 / 3 * (1 - t) * (1 - t) * (2 + t) : 0; }

TEST(Solid, box_has_the_curvature_of_its_volume) {
  const Subject subject(box(20));
  const double r = 0.3;
  const std::vector<double> mean = subject.values("mean_curvature", r);
  for (size_t v = 0; v < mean.size(); ++v) {
    const dvec3 depth = depths(subject.triangles.positions[v]);
    if (depth.y < r && depth.z < r && depth.z > 1e-6) continue; // two edges
    const double want = depth.z < 1e-6 ? 2 : beside_edge(depth.y / r);
    EXPECT_NEAR(mean[v] * r, want, 2e-6); // floats' rounding of positions
  }
}

TEST(Solid, edges_are_ridges_and_corners_are_caps) {
  const Subject subject(box(8));
  const double r = 0.05 * diagonal_of(subject.triangles); // as bake's default mapping is measured
  const auto of = [&](const char *name) { return subject.values(name, r); };
  const std::vector<double> convexity = of("convexity"), gauss = of("gaussian_curvature"), shape = of("shape_index"),
                            volume = of("sphere_volume_normalized"), bending = of("local_bending_energy");
  for (size_t v = 0; v < convexity.size(); ++v) {
    const dvec3 depth = depths(subject.triangles.positions[v]);
    const double k1 = (depth.z < 1e-6 ? 2 : 8.0 / 3) / r, k2 = depth.z < 1e-6 ? k1 : 0;
    if (depth.y > 1e-6) {
      EXPECT_EQ(convexity[v], 0);
      EXPECT_NEAR(volume[v], 0.5, 1e-6);
      EXPECT_TRUE(std::isnan(shape[v]));
      continue;
    }
    EXPECT_EQ(convexity[v], 1);
    EXPECT_NEAR(volume[v], depth.z < 1e-6 ? 0.125 : 0.25, 1e-6);
    // A ten-thousandth of what bends has no direction, so that opposite faces have one value.
    EXPECT_NEAR(gauss[v] * r * r, k1 * k2 * r * r, 1e-3);
    EXPECT_NEAR(shape[v], depth.z < 1e-6 ? 1 : 0.5, 1e-3);
    EXPECT_NEAR(bending[v] / (0.5 * (k1 * k1 + k2 * k2)), 1, 1e-3);
  }
}

TEST(Solid, prisms_follow_their_angles) {
  for (const int sides : {3, 4, 5, 6}) {
    const Subject subject(prism(sides, 4, 3));
    const double r = 0.2, inner = pi * (sides - 2) / sides;
    const std::vector<double> mean = subject.values("mean_curvature", r), k2 = subject.values("principal_curvature_min", r);
    for (size_t v = 0; v < mean.size(); ++v) {
      const vec3 p = subject.triangles.positions[v];
      if (std::abs(std::hypot(p.x, p.y) - 1) > 1e-5) continue;
      const bool corner = std::abs(p.z) > 0.9;
      // A wedge fills inner/(2 pi) of the ball, a corner of it half of that.
      const double filled = inner / (2 * pi) * (corner ? 0.5 : 1);
      EXPECT_NEAR(mean[v] * r, 16.0 / 3 * (0.5 - filled), 1e-5);
      if (!corner) {
        EXPECT_NEAR(k2[v] * r, 0, 1e-3);
      }
    }
  }
}

// The share of the ball that a predicate holds in, by a grid of 60³, turned so that no side of a solid runs along it.
double filled(dvec3 center, double r, const std::function<bool(dvec3)> &inside) {
  constexpr int n = 60;
  const Rotation turn = rotation_about({1, 2, 4}, 0.7);
  int64_t ball = 0, found = 0;
  for (int i = 0; i < n * n * n; ++i) {
    const dvec3 d = (2.0 * dvec3(i % n, i / n % n, i / (n * n)) + 1.0) / double{n} - 1.0;
    if (glm::dot(d, d) > 1) continue;
    ++ball;
    const Vec3 turned = turn({d.x, d.y, d.z});
    found += inside(center + r * dvec3(turned.x, turned.y, turned.z));
  }
  return static_cast<double>(found) / static_cast<double>(ball);
}

TEST(Solid, bevelled_box_has_the_curvature_of_its_volume) {
  const double width = 0.15;
  const Subject subject(bevelled_box(width));
  for (const double r : {0.1, 0.2, 0.3}) {
    const std::vector<double> mean = subject.values("mean_curvature", r);
    for (size_t v = 0; v < mean.size(); ++v) {
      const double share = filled(dvec3(subject.triangles.positions[v]), r, [&](dvec3 p) {
        const dvec3 a = glm::abs(p);
        return std::max({a.x, a.y, a.z}) < 1 && std::max({a.x + a.y, a.y + a.z, a.z + a.x}) < 2 - width &&
               a.x + a.y + a.z < 3 - 2 * width;
      });
      EXPECT_NEAR(mean[v] * r, 16.0 / 3 * (0.5 - share), 0.01); // the grid's
    }
  }
}

TEST(Solid, rim_of_a_cylinder_bends_both_ways) {
  const Subject subject(prism(64, 20, 10));
  const double r = 0.15;
  const std::vector<double> mean = subject.values("mean_curvature", r), k1 = subject.values("principal_curvature_max", r);
  for (size_t v = 0; v < mean.size(); v += 5) {
    const dvec3 p(subject.triangles.positions[v]);
    const double share = filled(p, r, [](dvec3 q) { return std::hypot(q.x, q.y) < 1 && std::abs(q.z) < 1; });
    // 64 sides: the cylinder lies up to 0.0012 outside of them, 0.008 of r; the shape operator's own bias is less.
    EXPECT_NEAR(mean[v] * r, 16.0 / 3 * (0.5 - share), 0.02);
    const bool side = std::hypot(p.x, p.y) > 0.999 && std::abs(p.z) < 1 - 1.3 * r;
    if (side) {
      EXPECT_NEAR(k1[v], 1, 0.01);
    }
  }
}

TEST(Solid, curvature_never_falls_on_the_way_to_an_edge) {
  for (const int sides : {16, 64}) {
    const Subject subject(prism(sides, 80, 1));
    const double r = 0.15;
    const std::vector<double> mean = subject.values("mean_curvature", r);
    std::vector<std::pair<double, double>> way; // height, H
    for (size_t v = 0; v < mean.size(); ++v)
      if (const vec3 p = subject.triangles.positions[v]; p.x > 0.9999 && p.z >= 0) way.emplace_back(p.z, mean[v]);
    std::sort(way.begin(), way.end());
    ASSERT_EQ(way.size(), 41u);
    EXPECT_NEAR(way.front().second, 0.5, 0.1); // 16 sides at half of their width are no cylinder
    for (size_t i = 1; i < way.size(); ++i) {
      EXPECT_GT(way[i].second, way[i - 1].second - 0.02) << way[i].first; // of 8.9 at the rim
      EXPECT_LT(way[i].second - way[i - 1].second, 2.7)
          << way[i].first; // steps of r/6, along each of which a straight edge adds up to 1/(3 r)
    }
  }
}

// Between r and 1.25 r from the rim, values are neither the solid's nor the smooth surface's, which noise makes differ.
TEST(Solid, all_curvatures_are_those_of_one_shape_operator) {
  Triangles noisy = prism(64, 80, 1);
  Random random(3);
  for (vec3 &p : noisy.positions) p += 2e-3f * vec3(random.normal(), random.normal(), random.normal());
  const Subject subject(std::move(noisy));
  const double r = 0.15;
  const auto of = [&](const char *name, bool with_creases = true) { return subject.values(name, r, with_creases); };
  const std::vector<double> k1 = of("principal_curvature_max"), k2 = of("principal_curvature_min"), mean = of("mean_curvature"),
                            gauss = of("gaussian_curvature"), index = of("shape_index"), bent = of("curvedness"),
                            convexity = of("convexity"), smooth = of("gaussian_curvature", false);
  int blended = 0;
  for (size_t v = 0; v < k1.size(); ++v) {
    EXPECT_NEAR(mean[v] * r, (k1[v] + k2[v]) / 2 * r, 1e-6);
    EXPECT_NEAR(gauss[v] * r * r, k1[v] * k2[v] * r * r, 1e-6);
    EXPECT_NEAR(bent[v] * r, std::hypot(k1[v], k2[v]) / std::sqrt(2) * r, 1e-6);
    EXPECT_NEAR(convexity[v], std::clamp(mean[v] * r, 0.0, 1.0), 1e-6);
    if (!std::isnan(index[v])) {
      EXPECT_NEAR(index[v], 2 / pi * std::atan2(k1[v] + k2[v], k1[v] - k2[v]), 1e-5);
    }
    const double depth = 1 - std::abs(subject.triangles.positions[v].z);
    blended += depth > r && depth < 1.25 * r && gauss[v] != smooth[v];
  }
  EXPECT_GT(blended, 100);
}

TEST(Solid, nothing_changes_where_no_crease_is) {
  const Subject smooth(read_triangles(input_of(torus(1, 0.4, {.vertices = 3000}))));
  EXPECT_EQ(smooth.values("mean_curvature", 0.1), smooth.values("mean_curvature", 0.1, false));
  const Subject solid(prism(32, 20, 1));
  const double r = 0.1;
  const std::vector<double> with = solid.values("mean_curvature", r), without = solid.values("mean_curvature", r, false);
  for (size_t v = 0; v < with.size(); ++v)
    if (std::abs(solid.triangles.positions[v].z) < 1 - 1.26 * r) {
      EXPECT_EQ(with[v], without[v]);
    }
}

// A box turned in space, in which points on edges between two others are off their line by less than floats are rounded, as
// polygons with such points leave them.
Triangles box_with_needles(double share, std::vector<dvec3> &places) {
  const Triangles plain = box(8);
  Triangles result;
  for (const vec3 &p : plain.positions) places.emplace_back(p);
  Random random(1);
  for (size_t t = 0; t < plain.corner_vertex.size(); t += 3) {
    const int32_t a = plain.corner_vertex[t], b = plain.corner_vertex[t + 1], c = plain.corner_vertex[t + 2];
    if (random.uniform() > 0.3) {
      result.corner_vertex.insert(result.corner_vertex.end(), {a, b, c});
      continue;
    }
    const auto q = static_cast<int32_t>(places.size());
    places.push_back((1 - share) * (0.4 * places[a] + 0.6 * places[b]) + share * places[c]);
    result.corner_vertex.insert(result.corner_vertex.end(), {a, b, q, b, c, q, c, a, q});
  }
  const Rotation turn = rotation_about({1, 2, 4}, 0.7);
  for (const dvec3 &p : places) {
    const Vec3 turned = turn({p.x, p.y, p.z});
    result.positions.emplace_back(turned.x, turned.y, turned.z);
  }
  return shape(std::move(result.positions), std::move(result.corner_vertex));
}

TEST(Solid, needles_change_nothing) {
  for (const double share : {1e-3, 1e-5, 1e-6, 3e-7}) {
    std::vector<dvec3> places;
    const Subject subject(box_with_needles(share, places));
    const double r = 0.2;
    const std::vector<double> mean = subject.values("mean_curvature", r);
    int needles = 0;
    for (int t = 0; t < subject.triangles.triangle_count; ++t)
      needles += steady_face(subject.triangles, subject.half_edges, t) != t;
    EXPECT_EQ(needles > 100, share < 1e-4) << share;
    for (size_t v = 0; v < mean.size(); ++v) {
      const dvec3 depth = depths(vec3(places[v]));
      if (depth.z < r && depth.z > 1e-6) continue; // near a corner
      EXPECT_NEAR(mean[v] * r, depth.z < 1e-6 ? 2 : beside_edge(std::max(depth.y, 0.0) / r), 5e-4)
          << share; // needles of 1e-3 have normals, turned by rounding
    }
  }
}

TEST(Solid, noise_leaves_edges_where_they_are) {
  Triangles noisy = box(16);
  Random random(2);
  for (vec3 &p : noisy.positions)
    p += 1e-3f *
         vec3(static_cast<float>(random.normal()), static_cast<float>(random.normal()), static_cast<float>(random.normal()));
  const std::vector<vec3> exact = box(16).positions;
  const Subject subject(std::move(noisy));
  EXPECT_EQ(subject.creases.edges.size(), 12 * 16);
  const double r = 0.4;
  const std::vector<double> mean = subject.values("mean_curvature", r);
  for (size_t v = 0; v < mean.size(); ++v) {
    const dvec3 depth = depths(exact[v]);
    if (depth.z < r && depth.z > 1e-6) continue;
    EXPECT_NEAR(mean[v] * r, depth.z < 1e-6 ? 2 : beside_edge(depth.y / r), 0.06); // 1/400 of r up or down moves it by 0.01
  }
}

// Both sides of a plate lie in the ball of its rim.
TEST(Solid, rim_of_a_thin_plate_has_the_curvature_of_its_volume) {
  Triangles plate = box(24);
  const float half = 0.04f;
  for (vec3 &p : plate.positions) p.z *= half;
  const Subject subject(std::move(plate));
  const double r = 0.2;
  const std::vector<double> mean = subject.values("mean_curvature", r);
  int looked = 0;
  for (size_t v = 0; v < mean.size(); ++v) {
    const dvec3 p(subject.triangles.positions[v]);
    if (std::max(std::abs(p.x), std::abs(p.y)) < 1 - 1e-6) continue;
    ++looked;
    const double share = filled(
        p, r, [&](dvec3 q) { return std::max(std::abs(q.x), std::abs(q.y)) < 1 && std::abs(q.z) < static_cast<double>(half); });
    EXPECT_NEAR(mean[v] * r, 16.0 / 3 * (0.5 - share), 0.01); // the grid's
  }
  EXPECT_GT(looked, 1000);
}

TEST(Solid, marked_edges_of_a_smooth_surface_change_little) {
  Triangles ball = read_triangles(input_of(sphere(1, {.vertices = 3000})));
  const HalfEdges half_edges = build_half_edges(ball);
  for (const int32_t h : {300, 600, 900}) ball.half_edge_sharp[h] = ball.half_edge_sharp[half_edges.twin[h]] = 1;
  const Subject subject(std::move(ball));
  EXPECT_EQ(subject.creases.edges.size(), 3);
  double most = 0; // that the facets bend at one
  for (int32_t h = 0; h < 3 * subject.triangles.triangle_count; ++h)
    if (subject.creases.contains(h)) most = std::max(most, bend_at(subject.triangles, subject.half_edges, h));
  const double r = 0.2, line = 4 / (3 * pi * r) * most; // H of an edge that bends by this and ends at the point
  EXPECT_LT(line, 0.2);
  for (const double mean : subject.values("mean_curvature", r)) EXPECT_NEAR(mean, 1, line);
}

TEST(Solid, a_hollow_is_as_bent_as_what_fits_into_it) {
  Triangles hollow = box(8);
  for (size_t c = 0; c < hollow.corner_vertex.size(); c += 3) std::swap(hollow.corner_vertex[c], hollow.corner_vertex[c + 1]);
  const Subject outside(box(8)), inside(std::move(hollow));
  const std::vector<double> convex = outside.values("mean_curvature", 0.3), concave = inside.values("mean_curvature", 0.3);
  for (size_t v = 0; v < convex.size(); ++v) EXPECT_NEAR(concave[v], -convex[v], 1e-5);
}

// The rim of the ball goes through corners of the box, which rounding puts on either side of it.
TEST(Solid, a_corner_on_the_rim_is_inside_or_outside_for_all_sides) {
  const Rotation turn = rotation_about({1, 2, 4}, 0.7);
  Triangles turned = box(10);
  for (vec3 &p : turned.positions) {
    const Vec3 place = turn({double{p.x}, double{p.y}, double{p.z}});
    p = vec3(place.x, place.y, place.z);
  }
  const Subject subject(std::move(turned));
  for (const double cells2 : {41, 50}) { // 6, 2 and 1 cells from a corner; 3, 4 and 5
    const double r = 0.2 * std::sqrt(cells2);
    const std::vector<double> mean = subject.values("mean_curvature", r),
                              beyond = subject.values("mean_curvature", r * (1 + 1e-6));
    for (size_t v = 0; v < mean.size(); ++v) EXPECT_NEAR(mean[v] * r, beyond[v] * r, 1e-4);
  }
}

} // namespace
} // namespace paradesc::test
