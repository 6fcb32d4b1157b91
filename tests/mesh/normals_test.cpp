// Normals of surfaces whose normals are known, of creases, of noise and of meshes that are no surface.
#include "mesh/normals.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "mesh/steady_faces.h"
#include "support/error.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr double degrees = 180 / 3.14159265358979323846;

struct Subject {
  Triangles triangles;
  HalfEdges half_edges;
  NormalRings rings;

  explicit Subject(Triangles list)
      : triangles(std::move(list)), half_edges(build_half_edges(triangles)), rings(build_normal_rings(triangles, half_edges)) {}
  explicit Subject(const TestMesh &mesh) : Subject(read_triangles(input_of(mesh))) {}
  Normals normals(int32_t kind, int threads = 0) const { return compute_normals(triangles, half_edges, rings, kind, threads); }
};

double angle_between(dvec3 a, dvec3 b) { return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * degrees; }

struct AngleError {
  double mean = 0, max = 0;
};

AngleError angle_error(const TestMesh &mesh, const Subject &subject, int32_t kind) {
  const Normals normals = subject.normals(kind);
  AngleError error;
  for (size_t v = 0; v < mesh.normals.size(); ++v) {
    const auto point = static_cast<size_t>(subject.half_edges.vertex_point[v]);
    const Vec3 n = mesh.normals[v];
    const double angle = angle_between(dvec3(normals.point[point]), dvec3(n.x, n.y, n.z));
    error.mean += angle / static_cast<double>(mesh.normals.size());
    error.max = std::max(error.max, angle);
  }
  return error;
}

AngleError angle_error(const TestMesh &mesh, int32_t kind) { return angle_error(mesh, Subject(mesh), kind); }

// Each side of [-1, 1]³ as a grid of cells by cells, welded by position; outward.
Triangles cube(int cells) {
  std::vector<vec3> positions;
  std::vector<int32_t> corners;
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const float sign = side % 2 ? -1.0f : 1.0f;
    const auto first = static_cast<int32_t>(positions.size());
    for (int j = 0; j <= cells; ++j)
      for (int i = 0; i <= cells; ++i) {
        vec3 p(0);
        p[axis] = sign;
        p[(axis + 1) % 3] = sign * (2 * static_cast<float>(i) / static_cast<float>(cells) - 1);
        p[(axis + 2) % 3] = 2 * static_cast<float>(j) / static_cast<float>(cells) - 1;
        positions.push_back(p);
      }
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        const int32_t a = first + j * (cells + 1) + i, b = a + 1, d = a + cells + 1, c = d + 1;
        corners.insert(corners.end(), {a, b, c, a, c, d});
      }
  }
  return shape(positions, corners);
}

dvec3 area_vector(const Triangles &triangles, int face) {
  const auto p = [&](int k) { return dvec3(triangles.positions[triangles.corner_vertex[3 * face + k]]); };
  return glm::cross(p(1) - p(0), p(2) - p(0));
}

// Marks edges between faces that do not lie in one plane, as if a user had.
void mark_bent_edges(Triangles &triangles) {
  const Subject unmarked(triangles);
  const auto face_normal = [&](size_t corner) { return area_vector(triangles, static_cast<int>(corner / 3)); };
  for (size_t h = 0; h < triangles.corner_vertex.size(); ++h) {
    const int32_t twin = unmarked.half_edges.twin[h];
    if (twin >= 0 && angle_between(face_normal(h), face_normal(static_cast<size_t>(twin))) > 1) triangles.half_edge_sharp[h] = 1;
  }
}

bool is_unit(vec3 v) { return std::abs(glm::length(dvec3(v)) - 1) < 1e-6; } // float rounding of three coordinates

TEST(Normals, max_are_exact_on_a_sphere) {
  // Max's weights give the exact normal of any polyhedron inscribed in a sphere. Positions are floats: 6e-8 of the radius over an
  // edge of 0.05 is 7e-5 degrees, times the irregularity of the fan.
  EXPECT_LT(angle_error(sphere(1, {.vertices = 5000}), PDESC_NORMALS_MAX).max, 1e-3);
}

TEST(Normals, fitted_come_near_the_exact_ones) {
  // Cubic jets have a mean error of 0.002 to 0.004 degrees on such meshes, quadratic ones of 0.016 to 0.025: the bound is
  // between.
  const TestMesh bent = torus(1, 0.4, {.vertices = 15000});
  const AngleError on_torus = angle_error(bent, PDESC_NORMALS_FITTED);
  EXPECT_LT(on_torus.mean, 0.012);
  EXPECT_LT(on_torus.max, 0.1);
  EXPECT_LT(angle_error(ellipsoid(1.5, 1, 0.7, {.vertices = 22000}), PDESC_NORMALS_FITTED).mean, 0.002);
  EXPECT_GT(angle_error(bent, PDESC_NORMALS_MAX).mean, 10 * on_torus.mean);
}

TEST(Normals, fitted_converge_with_the_cube_of_the_edge_length) {
  // Cazals and Pouget: the gradient of a jet of degree n has error h^n. Four times the vertices halve h: cubic 8, quadratic 4.
  const double coarse = angle_error(torus(1, 0.4, {.vertices = 8000}), PDESC_NORMALS_FITTED).mean;
  const double fine = angle_error(torus(1, 0.4, {.vertices = 32000}), PDESC_NORMALS_FITTED).mean;
  EXPECT_GT(coarse, 6 * fine); // nearer to the former
}

TEST(Normals, fitted_hold_at_a_boundary) {
  // One-sided fits are worse than those inside (mean 0.001 degrees against 0.0003), but the tangent plane of Max is far worse
  // there.
  const TestMesh open = saddle(1, {.vertices = 5000});
  EXPECT_LT(angle_error(open, PDESC_NORMALS_FITTED).max, 0.02);
  EXPECT_GT(angle_error(open, PDESC_NORMALS_MAX).max, 0.4);
}

TEST(Normals, fitted_dampen_small_noise) {
  // 1e-4 of the diagonal is 2 % of an edge. The fit averages over 18 neighbors and more, Max's over six faces.
  TestMesh mesh = torus(1, 0.4, {.vertices = 15000});
  add_noise(mesh, 1e-4, 3);
  const Subject subject(mesh);
  EXPECT_LT(angle_error(mesh, subject, PDESC_NORMALS_FITTED).mean, angle_error(mesh, subject, PDESC_NORMALS_MAX).mean / 3);
}

TEST(Normals, fitted_are_no_farther_off_than_max_under_noise) {
  for (const double noise : {1e-3, 1e-2}) { // a fifth of an edge, and twice an edge
    TestMesh mesh = torus(1, 0.4, {.vertices = 15000});
    add_noise(mesh, noise, 3);
    const Subject subject(mesh);
    const Normals fitted = subject.normals(PDESC_NORMALS_FITTED);
    for (const vec3 normal : fitted.point) ASSERT_TRUE(is_unit(normal));
    EXPECT_LE(angle_error(mesh, subject, PDESC_NORMALS_FITTED).mean, angle_error(mesh, subject, PDESC_NORMALS_MAX).mean);
  }
}

// Fits to coarse rings leave more of what bends within them than small noise would.
TEST(Normals, of_a_coarse_surface_stay_fitted) {
  EXPECT_LT(angle_error(torus(1, 0.4, {.vertices = 300}), PDESC_NORMALS_FITTED).mean, 5); // the mean of faces alone: 7
  EXPECT_LT(angle_error(torus(1, 0.4, {.vertices = 500}), PDESC_NORMALS_FITTED).mean, 1.8);
}

// At the open end of z = bend x², faces have the slope `bend` and a fit has none. A fit that leaves the faces by 12 degrees and
// more is not believed.
TEST(Normals, fitted_give_way_to_the_faces_where_they_leave_these_far) {
  for (const auto &[bend, expected] : {std::pair(0.1f, 0.0), std::pair(0.3f, 16.7)}) {
    std::vector<vec3> positions;
    std::vector<int32_t> corners;
    for (int32_t i = 0; i < 28; ++i) {
      const vec2 at(i / 7, i % 7 - 3);
      positions.emplace_back(at, bend * at.x * at.x);
      if (i % 7 < 6 && i < 21) corners.insert(corners.end(), {i, i + 7, i + 8, i, i + 8, i + 1});
    }
    const Subject subject(shape(positions, corners));
    const vec3 normal = subject.normals(PDESC_NORMALS_FITTED).point[subject.half_edges.vertex_point[3]];
    EXPECT_NEAR(angle_between(dvec3(normal), dvec3(0, 0, 1)), expected, 0.5) << bend;
  }
}

// Vertices lie off every smooth fit by a third of an edge, and the areas of triangles differ.
TEST(Normals, of_a_rough_surface_are_the_mean_of_the_faces_around_by_area) {
  TestMesh mesh = torus(1, 0.4, {.vertices = 6000});
  add_noise(mesh, 5e-3, 3);
  const Subject subject(mesh);
  const Normals fitted = subject.normals(PDESC_NORMALS_FITTED);
  int means = 0;
  for (int fan = 0; fan < subject.rings.fan_count; ++fan) {
    dvec3 sum(0);
    for (int64_t i = subject.rings.face_begin[fan]; i < subject.rings.face_begin[fan + 1]; ++i)
      sum += area_vector(subject.triangles, subject.rings.face[i]);
    means += angle_between(sum, dvec3(fitted.point[subject.rings.fan_point[fan]])) < 0.01;
  }
  EXPECT_GT(means, 0.8 * subject.rings.fan_count);
}

// Two rings around a vertex of an icosahedron hold all of its faces, whose vector areas sum up to rounding.
TEST(Normals, of_an_icosahedron_are_not_the_mean_of_faces_that_cancel) {
  constexpr float t = 1.618034f;
  const std::vector<int32_t> corners{0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                                     4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                                     6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
  for (const double turn : {0.1, 1.0, 2.0}) {
    const dmat3 around(std::cos(turn), std::sin(turn), 0, -std::sin(turn), std::cos(turn), 0, 0, 0, 1);
    std::vector<vec3> positions{{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                                {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
    for (vec3 &position : positions) position = vec3(around * dvec3(position));
    const Subject subject(shape(positions, corners));
    const Normals normals = subject.normals(PDESC_NORMALS_FITTED);
    for (size_t v = 0; v < positions.size(); ++v) // 1e-3 degrees: the positions are rounded; the mean of all faces was anywhere
      EXPECT_LT(angle_between(dvec3(normals.point[static_cast<size_t>(subject.half_edges.vertex_point[v])]), dvec3(positions[v])),
                1e-3);
  }
}

// A vertex more beside another, in the middle of a triangle's corner: slivers, whose directions say nothing.
TEST(Normals, one_vertex_beside_another_turns_none) {
  const TestMesh smooth = torus(1, 0.4, {.vertices = 3000});
  const Subject before(smooth);
  const double edge = glm::length(along(before.triangles, 0));
  for (const double distance : {1e-6, 1e-4, 1e-2})
    for (const dvec3 way : {dvec3(1, 0, 0), dvec3(0, 0.6, 0.8), dvec3(-0.6, 0, 0.8)}) {
      TestMesh mesh = smooth;
      const int32_t own = mesh.corner_vertices[0], next = mesh.corner_vertices[1], last = mesh.corner_vertices[2];
      for (int k = 0; k < 3; ++k)
        mesh.positions.push_back(mesh.positions[static_cast<size_t>(3 * own + k)] + static_cast<float>(distance * edge * way[k]));
      const int32_t added = mesh.vertex_count++;
      mesh.corner_vertices[2] = added;
      for (const int32_t vertex : {next, last, added, last, own, added}) {
        mesh.triangle_corners.push_back(static_cast<int32_t>(mesh.corner_vertices.size()));
        mesh.corner_vertices.push_back(vertex);
      }
      mesh.corner_normals.clear();
      mesh.corner_uvs.clear();
      const Subject subject(mesh);
      const Normals truth = before.normals(PDESC_NORMALS_FITTED), found = subject.normals(PDESC_NORMALS_FITTED);
      // Rings that hold the vertex more reach less far. With faces that count whatever their areas it was up to 90.
      for (size_t v = 0; v < static_cast<size_t>(smooth.vertex_count); ++v)
        ASSERT_LT(angle_between(dvec3(found.point[static_cast<size_t>(subject.half_edges.vertex_point[v])]),
                                dvec3(truth.point[static_cast<size_t>(before.half_edges.vertex_point[v])])),
                  0.5)
            << distance << " " << v;
    }
}

TEST(Normals, cube_with_sharp_edges_keeps_its_face_normals) {
  Triangles marked = cube(6);
  mark_bent_edges(marked);
  const Subject subject(marked);
  for (const int32_t kind : {PDESC_NORMALS_FITTED, PDESC_NORMALS_MAX}) {
    const Normals normals = subject.normals(kind);
    for (size_t corner = 0; corner < subject.triangles.corner_vertex.size(); ++corner) {
      const auto p = [&](size_t k) {
        return subject.triangles.positions[static_cast<size_t>(subject.triangles.corner_vertex[k])];
      };
      const size_t a = corner / 3 * 3;
      const dvec3 face = glm::cross(dvec3(p(a + 1) - p(a)), dvec3(p(a + 2) - p(a)));
      ASSERT_LT(angle_between(dvec3(normals.corner(corner)), face), 1e-5); // float rounding
    }
  }
}

TEST(Normals, cube_with_sharp_edges_has_mean_normals_at_its_points) {
  Triangles marked = cube(1);
  mark_bent_edges(marked);
  const Subject subject(marked);
  ASSERT_EQ(subject.half_edges.point_count, 8);
  EXPECT_EQ(subject.rings.fan_count, 24); // three at each vertex
  const Normals normals = subject.normals(PDESC_NORMALS_FITTED);
  for (size_t p = 0; p < 8; ++p) { // each side takes a right angle, by one triangle or by two
    const vec3 position = subject.triangles.positions[static_cast<size_t>(subject.half_edges.point_vertex[p])];
    EXPECT_LT(angle_between(dvec3(normals.point[p]), dvec3(position)), 1e-5); // float rounding
  }
}

// Farther than two rings from its corners.
TEST(Normals, cube_without_marks_has_the_mean_of_both_sides_at_its_edges) {
  const Subject subject(cube(6));
  const Normals fitted = subject.normals(PDESC_NORMALS_FITTED);
  for (size_t p = 0; p < fitted.point.size(); ++p) {
    const dvec3 position(subject.triangles.positions[static_cast<size_t>(subject.half_edges.point_vertex[p])]);
    const dvec3 sides = glm::floor(glm::abs(position)) * glm::sign(position); // 1 and -1 on a side of the cube
    if (glm::dot(sides, sides) == 2 && glm::dot(position, position) < 2.2) {
      EXPECT_LT(angle_between(dvec3(fitted.point[p]), glm::normalize(sides)), 1e-4);
    }
  }
}

TEST(Normals, an_edge_sharp_on_one_side_only_is_no_crease) {
  Triangles triangles = cube(1);
  mark_bent_edges(triangles);
  const HalfEdges half_edges = build_half_edges(triangles);
  for (size_t h = 0; h < half_edges.twin.size(); ++h)
    if (half_edges.twin[h] > static_cast<int32_t>(h)) triangles.half_edge_sharp[h] = 0; // that side is flat shaded
  EXPECT_EQ(Subject(triangles).rings.fan_count, 8);
}

TEST(Normals, a_crease_that_ends_on_the_surface_leaves_one_fan_at_its_end) {
  TestMesh mesh = plane(1, 1, {.vertices = 400, .irregular = false});
  Triangles triangles = read_triangles(input_of(mesh));
  const HalfEdges half_edges = build_half_edges(triangles);
  size_t inner = 0; // any edge between two inner points
  while (half_edges.twin[inner] < 0 || half_edges.point_boundary[static_cast<size_t>(half_edges.corner_point[inner])] ||
         half_edges.point_boundary[static_cast<size_t>(
             half_edges.corner_point[static_cast<size_t>(next_corner(static_cast<int>(inner)))])])
    ++inner;
  triangles.half_edge_sharp[inner] = triangles.half_edge_sharp[static_cast<size_t>(half_edges.twin[inner])] = 1;
  EXPECT_EQ(Subject(triangles).rings.fan_count, half_edges.point_count);
}

TEST(Normals, rings_do_not_reach_across_creases) {
  Triangles marked = cube(6);
  mark_bent_edges(marked);
  const Subject subject(marked);
  for (int fan = 0; fan < subject.rings.fan_count; ++fan) {
    const auto f = static_cast<size_t>(fan);
    const auto begin = static_cast<size_t>(subject.rings.face_begin[f]),
               end = static_cast<size_t>(subject.rings.face_begin[f + 1]);
    const int32_t side = subject.rings.face[begin] / (2 * 6 * 6);
    for (size_t i = begin; i < end; ++i) ASSERT_EQ(subject.rings.face[i] / (2 * 6 * 6), side);
  }
}

TEST(Normals, rings_hold_each_point_once_and_start_with_the_nearest) {
  const Subject subject(torus(1, 0.4, {.vertices = 2000}));
  for (size_t fan = 0; fan < static_cast<size_t>(subject.rings.fan_count); ++fan) {
    const auto begin = subject.rings.ring_vertex.begin() + subject.rings.ring_begin[fan];
    std::vector<int32_t> vertices(begin, subject.rings.ring_vertex.begin() + subject.rings.ring_begin[fan + 1]);
    const int64_t valence = subject.rings.fan_begin[fan + 1] - subject.rings.fan_begin[fan] - 2; // itself, and the first twice
    for (int64_t i = 0; i < valence; ++i) {
      bool adjacent = false;
      for (size_t c = 0; c < subject.rings.corner_fan->size() && !adjacent; ++c) {
        const auto end = static_cast<size_t>(next_corner(static_cast<int>(c)));
        adjacent = (*subject.rings.corner_fan)[c] == static_cast<int32_t>(fan) &&
                   subject.triangles.corner_vertex[end] == vertices[static_cast<size_t>(i)];
      }
      ASSERT_TRUE(adjacent);
    }
    std::sort(vertices.begin(), vertices.end());
    EXPECT_EQ(std::adjacent_find(vertices.begin(), vertices.end()), vertices.end());
    EXPECT_FALSE(std::binary_search(vertices.begin(), vertices.end(),
                                    subject.rings.fan_vertex[static_cast<size_t>(subject.rings.fan_begin[fan])]));
    if (fan == 40) break; // each is the same walk; the search above is slow
  }
}

TEST(Normals, a_fan_of_thousands_of_faces_costs_no_more_than_its_faces) {
  constexpr int count = 20000; // a cone: its apex neighbors everything, and everything has the apex' fan in its rings
  const Subject subject(cone(count));
  EXPECT_LT(subject.rings.ring_vertex.size(), size_t{count} * 100); // its square would be 4e8
  const Normals normals = subject.normals(PDESC_NORMALS_FITTED);
  const auto apex = static_cast<size_t>(subject.half_edges.vertex_point[0]);
  EXPECT_LT(angle_between(dvec3(normals.point[apex]), dvec3(0, 0, 1)), 0.01); // edges of 3e-4 on floats of 6e-8
}

TEST(Normals, vertices_split_by_an_exporter_change_nothing) {
  const Triangles whole = read_triangles(input_of(torus(1, 0.4, {.vertices = 3000})));
  std::vector<vec3> positions;
  std::vector<int32_t> corners;
  for (const int32_t vertex : whole.corner_vertex) {
    corners.push_back(static_cast<int32_t>(corners.size()));
    positions.push_back(whole.positions[static_cast<size_t>(vertex)]);
  }
  const Normals expected = Subject(whole).normals(PDESC_NORMALS_FITTED);
  const Normals found = Subject(shape(positions, corners)).normals(PDESC_NORMALS_FITTED);
  EXPECT_EQ(found.group, expected.group); // bit for bit: the same points in the same order
}

TEST(Normals, mesh_normals_are_those_given) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  const Subject subject(mesh);
  const Normals normals = subject.normals(PDESC_NORMALS_MESH);
  for (size_t i = 0; i < subject.triangles.corner_vertex.size(); ++i)
    ASSERT_LT(glm::length(normals.corner(i) - subject.triangles.corner_normal[i]), 3e-7f); // normalized again, in float
  EXPECT_LT(angle_error(mesh, PDESC_NORMALS_MESH).max, 1e-4);                              // float rounding
}

TEST(Normals, mesh_normals_must_have_been_given) {
  TestMesh mesh = sphere(1, {.vertices = 100});
  mesh.corner_normals.clear();
  const Subject subject(mesh);
  try {
    subject.normals(PDESC_NORMALS_MESH);
    FAIL() << "no error";
  } catch (const Error &error) {
    EXPECT_EQ(error.status(), PDESC_ERROR_INVALID_OPERATION);
    EXPECT_NE(std::string(error.what()).find("corner_normals"), std::string::npos);
  }
}

TEST(Normals, zero_mesh_normals_become_those_of_the_face) {
  TestMesh mesh = plane(1, 1, {.vertices = 100});
  std::fill(mesh.corner_normals.begin(), mesh.corner_normals.end(), 0.0f);
  for (const vec3 n : Subject(mesh).normals(PDESC_NORMALS_MESH).group) EXPECT_EQ(n, vec3(0, 0, 1));
}

TEST(Normals, faces_back_to_back_have_the_normal_of_one_of_them) {
  const Subject subject(shape({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2, 0, 2, 1}));
  for (const int32_t kind : {PDESC_NORMALS_FITTED, PDESC_NORMALS_MAX})
    for (const vec3 n : subject.normals(kind).point) EXPECT_EQ(std::abs(n.z), 1.0f);
}

TEST(Normals, degenerate_triangles_have_none_and_spoil_none) {
  // A square of two triangles, and one without area.
  const Subject subject(shape({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 2, 0}}, {0, 1, 2, 0, 2, 3, 0, 2, 4}));
  const Normals normals = subject.normals(PDESC_NORMALS_FITTED);
  for (size_t i = 0; i < 9; ++i) EXPECT_EQ(normals.corner(i), i < 6 ? vec3(0, 0, 1) : vec3(0));
}

TEST(Normals, tiny_and_huge_meshes_have_the_normals_of_any) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 2000});
  const double expected = angle_error(mesh, PDESC_NORMALS_FITTED).mean;
  for (const double factor : {1e-12, 1e12}) {
    TestMesh scaled = mesh;
    scale(scaled, factor);
    EXPECT_NEAR(angle_error(scaled, PDESC_NORMALS_FITTED).mean, expected, 1e-5); // other float roundings
  }
}

TEST(Normals, do_not_depend_on_the_number_of_threads) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 5000});
  const Subject subject(mesh);
  const NormalRings alone = build_normal_rings(subject.triangles, subject.half_edges, 1);
  const NormalRings five = build_normal_rings(subject.triangles, subject.half_edges, 5);
  EXPECT_EQ(alone.ring_vertex, five.ring_vertex);
  EXPECT_EQ(alone.face, five.face);
  const Normals one = subject.normals(PDESC_NORMALS_FITTED, 1), four = subject.normals(PDESC_NORMALS_FITTED, 4);
  EXPECT_EQ(one.group, four.group);
  EXPECT_EQ(one.point, four.point);
}

TEST(Normals, of_one_frame_have_the_bits_of_those_whose_rings_are_kept) {
  const TestMesh mesh = torus(1, 0.4, {.vertices = 20000}); // several runs of rings
  const Subject subject(mesh);
  for (const int32_t kind : {PDESC_NORMALS_FITTED, PDESC_NORMALS_MAX}) {
    const Normals kept = subject.normals(kind);
    const Normals once = compute_normals_once(subject.triangles, subject.half_edges,
                                              marked_creases(subject.triangles, subject.half_edges), kind, 2);
    EXPECT_EQ(once.group, kept.group);
    EXPECT_EQ(once.point, kept.point);
    EXPECT_EQ(*once.corner_fan, *kept.corner_fan);
  }
}

TEST(Normals, of_an_empty_mesh_are_empty) {
  const Subject subject(shape({}, {}));
  EXPECT_TRUE(subject.normals(PDESC_NORMALS_FITTED).point.empty());
}

} // namespace
} // namespace paradesc::test
