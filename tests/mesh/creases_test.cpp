// Creases where a solid has edges, and none where a smooth surface is coarse, flat-shaded or noisy.
#include "mesh/creases.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "support/creases.h"
#include "support/real_mesh.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

constexpr double degree = pi / 180;

struct Found {
  int32_t edges = 0, bent = 0; // creases; edges that bend by more than a degree
  double least = 10, most = 0; // bends of creases
};

Found find(const Triangles &triangles, int threads = 0) {
  const HalfEdges half_edges = build_half_edges(triangles);
  const Creases creases = creases_of(triangles, half_edges, threads);
  Found found{static_cast<int32_t>(creases.edges.size())};
  for (int h = 0; h < 3 * triangles.triangle_count; ++h) {
    const double bend = std::abs(bend_at(triangles, half_edges, h));
    if (half_edges.twin[static_cast<size_t>(h)] > h && bend > degree) ++found.bent;
    if (!creases.contains(h)) continue;
    found.least = std::min(found.least, bend);
    found.most = std::max(found.most, bend);
  }
  return found;
}

Found find(const TestMesh &mesh) { return find(read_triangles(input_of(mesh))); }

// Every edge that bends is one.
void expect_all(const Triangles &triangles, int edges) {
  const Found found = find(triangles);
  EXPECT_EQ(found.edges, edges);
  EXPECT_EQ(found.bent, edges);
}

TEST(Creases, a_box_has_its_edges_however_it_is_divided) {
  for (const int cells : {1, 2, 3, 8}) expect_all(box(cells), 12 * cells);
}

TEST(Creases, prisms_have_all_of_their_edges) {
  for (const int sides : {3, 4, 5, 6}) expect_all(prism(sides), 3 * sides);
}

Triangles gable(float depth) {
  const float x = depth / 2;
  return shape({{-x, -0.36f, 0}, {-x, 0.36f, 0}, {-x, 0, 0.32f}, {x, -0.36f, 0}, {x, 0.36f, 0}, {x, 0, 0.32f}},
               {0, 2, 1, 3, 4, 5, 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5});
}

Triangles slanted_beam(float length, float slant) {
  Triangles beam = box(1);
  for (vec3 &p : beam.positions) p = {length * p.x, p.y, p.z + slant * length * p.x};
  return beam;
}

TEST(Creases, a_roof_of_one_triangle_a_gable_has_all_of_its_edges) {
  for (const float depth : {0.25f, 0.5f, 1.0f, 2.0f}) expect_all(gable(depth), 9);
}

TEST(Creases, a_beam_that_is_cut_at_a_slant_has_all_of_its_edges) {
  for (const float slant : {0.25f, 0.5f})
    for (const float length : {0.5f, 1.0f, 2.0f, 4.0f}) expect_all(slanted_beam(length, slant), 12);
}

TEST(Creases, corners_are_found_under_noise) {
  for (unsigned seed = 0; seed < 5; ++seed)
    for (const auto &[solid, edges] : {std::pair(gable(1), 9), std::pair(slanted_beam(2, 0.5f), 12)}) {
      Triangles noisy = solid;
      const auto most = static_cast<float>(0.01 * diagonal_of(noisy));
      std::mt19937 generator(seed);
      std::uniform_real_distribution<float> noise(-most, most);
      for (vec3 &p : noisy.positions) p += vec3(noise(generator), noise(generator), noise(generator));
      EXPECT_EQ(find(noisy).edges, edges) << seed;
    }
}

TEST(Creases, a_bevel_of_one_segment_has_both_of_its_edges) {
  for (const double width : {0.02, 0.1}) expect_all(bevelled_box(width), 48);
}

TEST(Creases, a_cylinder_has_its_rims_alone) {
  for (const int sides : {8, 12, 16, 32, 64})
    for (const int rows : {1, 5}) {
      const Found found = find(prism(sides, rows, rows));
      EXPECT_EQ(found.edges, 2 * sides);
      EXPECT_NEAR(found.least, 90 * degree, 1e-3);
    }
}

TEST(Creases, smooth_surfaces_have_none_however_coarse) {
  for (const int vertices : {60, 200, 2000})
    for (const bool irregular : {false, true}) {
      const Triangulation triangulation{.vertices = vertices, .irregular = irregular};
      EXPECT_EQ(find(sphere(1, triangulation)).edges, 0);
      EXPECT_EQ(find(ellipsoid(1.5, 1, 0.7, triangulation)).edges, 0);
    }
  for (const int vertices : {400, 2000}) EXPECT_EQ(find(torus(1, 0.4, {.vertices = vertices})).edges, 0);
}

TEST(Creases, noise_is_none) {
  TestMesh noisy = torus(1, 0.4, {.vertices = 5000});
  add_noise(noisy, 0.003, 5); // a fifth of an edge: half of the edges bend by more than 20 degrees
  const Found found = find(noisy);
  EXPECT_GT(found.bent, 14000);
  EXPECT_EQ(found.edges, 0);
}

// Vertices of a grid on a torus, moved along it by up to this share of a cell: from 0.35 on some triangles are folded over.
TestMesh moved_torus(int columns, int rows, double most) {
  std::mt19937 generator(0);
  std::uniform_real_distribution<double> share(-most, most);
  TestMesh mesh;
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      const double u = 2 * pi * (i + share(generator)) / columns, v = 2 * pi * (j + share(generator)) / rows,
                   ring = 1 + 0.4 * std::cos(v);
      for (const double x : {ring * std::cos(u), ring * std::sin(u), 0.4 * std::sin(v)})
        mesh.positions.push_back(static_cast<float>(x));
      const auto at = [&](int a, int b) { return (i + a) % columns * rows + (j + b) % rows; };
      for (const int32_t vertex : {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)}) {
        mesh.triangle_corners.push_back(static_cast<int32_t>(mesh.corner_vertices.size()));
        mesh.corner_vertices.push_back(vertex);
      }
    }
  mesh.vertex_count = columns * rows;
  return mesh;
}

// Some triangles there have three edges of 60 degrees the same way.
TEST(Creases, triangles_that_noise_lifts_are_none) {
  for (unsigned seed = 1; seed < 6; ++seed) {
    TestMesh noisy = moved_torus(224, 90, 0.2);
    std::mt19937 generator(seed);
    std::normal_distribution<float> noise(0, 0.0095f); // three tenths of an edge
    for (float &x : noisy.positions) x += noise(generator);
    EXPECT_EQ(find(noisy).edges, 0) << seed;
  }
}

TEST(Creases, folded_triangles_are_none) {
  for (const double most : {0.35, 0.4, 0.45}) {
    const Found found = find(moved_torus(160, 64, most));
    EXPECT_EQ(found.edges, 0) << most;
    EXPECT_GT(found.bent, 0);
  }
}

// Edges found on boxes whose vertices are moved by up to this share of a cell along each axis, over those of the boxes.
double share_found_under_noise(float share) {
  double found = 0, all = 0;
  for (unsigned seed = 0; seed < 5; ++seed) {
    Triangles solid = box(16); // of cells of an eighth
    all += find(solid).edges;
    std::mt19937 generator(seed);
    std::uniform_real_distribution<float> noise(-share / 8, share / 8);
    for (vec3 &p : solid.positions) p += vec3(noise(generator), noise(generator), noise(generator));
    found += find(solid).edges;
  }
  return found / all;
}

TEST(Creases, edges_of_a_noisy_solid_are_found) {
  EXPECT_EQ(share_found_under_noise(0.05f), 1);
  EXPECT_EQ(share_found_under_noise(0.1f), 1);
  EXPECT_GE(share_found_under_noise(0.2f), 0.95); // 0.85 without the edges that noise hides in a line
}

TEST(Creases, a_marked_edge_is_one_by_itself) {
  Triangles triangles = read_triangles(input_of(sphere(1, {.vertices = 500})));
  const HalfEdges half_edges = build_half_edges(triangles);
  triangles.half_edge_sharp[30] = 1;
  EXPECT_EQ(creases_of(triangles, half_edges).edges.size(), 0); // the face behind it is flat
  triangles.half_edge_sharp[static_cast<size_t>(half_edges.twin[30])] = 1;
  EXPECT_EQ(creases_of(triangles, half_edges).edges.size(), 1);
  EXPECT_EQ(marked_creases(triangles, half_edges), creases_of(triangles, half_edges));
}

TEST(Creases, do_not_depend_on_threads_size_or_place) {
  Triangles triangles = prism(7, 4, 3);
  const HalfEdges half_edges = build_half_edges(triangles);
  const Creases creases = creases_of(triangles, half_edges, 1);
  EXPECT_EQ(creases, creases_of(triangles, half_edges, 3));
  for (vec3 &p : triangles.positions) p = 1024.0f * vec3(p.y, p.z, p.x); // exact in floats, and turned
  EXPECT_EQ(creases, creases_of(triangles, half_edges));
  for (int power = 10; power < 57; ++power) { // up to where squares of squares, then squares are more than floats hold
    for (vec3 &p : triangles.positions) p *= 2.0f;
    ASSERT_EQ(creases, creases_of(triangles, half_edges)) << "times 2^" << power + 1;
  }
}

struct RealCount {
  const char *name;
  int32_t least, most;
};
void expect_count(const RealCount &real) {
  PDESC_REAL_MESH(mesh, real.name);
  const Found found = find(mesh);
  EXPECT_GE(found.edges, real.least) << real.name;
  EXPECT_LE(found.edges, real.most) << real.name;
}

// As counted when their pictures were looked at: lines around the eyes of beast and human, where separate surfaces end.
TEST(Creases, organic_meshes_have_hardly_any) {
  for (const RealCount &real : {RealCount{"spot", 0, 0},
                                {"bob", 0, 0},
                                {"rocker-arm", 0, 0},
                                {"stanford-bunny", 0, 20},
                                {"beast", 0, 250},
                                {"human", 0, 120}})
    expect_count(real);
}

TEST(Creases, machine_parts_and_buildings_have_many) {
  for (const RealCount &real : {RealCount{"fandisk", 700, 770}, {"barracks", 5800, 6400}}) expect_count(real);
}

TEST(CountingCreases, count_where_they_bend_as_much_as_what_lies_around) {
  const Triangles solid = box(8);
  const HalfEdges half_edges = build_half_edges(solid);
  const Creases found = creases_of(solid, half_edges);
  for (const double radius : {0.01, 0.1, 1.0})
    EXPECT_EQ(creases_that_count(solid, half_edges, found, rounded_normals(solid, half_edges), radius), found);
}

// The faces of a ball of voxels. Its radius is a whole number of voxels, so one voxel stands out at each pole.
Triangles ball_of_voxels(int radius) {
  const auto is_inside = [&](glm::ivec3 at) { return at.x * at.x + at.y * at.y + at.z * at.z <= radius * radius; };
  const int side = 2 * radius + 2;
  std::map<int, int32_t> numbers; // of grid corners
  std::vector<vec3> positions;
  std::vector<int32_t> corners;
  const auto vertex = [&](glm::ivec3 at) {
    const auto [found, is_new] = numbers.try_emplace((at.x * side + at.y) * side + at.z, static_cast<int32_t>(positions.size()));
    if (is_new) positions.emplace_back(at);
    return found->second;
  };
  for (int i = 0; i < side * side * side; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const glm::ivec3 at(i / (side * side), i / side % side, i % side), middle(radius);
      glm::ivec3 across(0), first(0), second(0);
      across[axis] = first[(axis + 1) % 3] = second[(axis + 2) % 3] = 1;
      const bool below = is_inside(at - across - middle), above = is_inside(at - middle);
      if (below == above) continue;
      if (above) std::swap(first, second);
      const int32_t quad[4] = {vertex(at), vertex(at + first), vertex(at + first + second), vertex(at + second)};
      for (const int k : {0, 1, 2, 0, 2, 3}) corners.push_back(quad[k]);
    }
  return shape(positions, corners);
}

// The voxel that stands out has hard edges of its own, and at a radius of some voxels it is one step among many.
TEST(CountingCreases, single_steps_among_others_as_sharp_do_not_count) {
  for (const int voxels : {10, 15, 20}) {
    const Triangles ball = ball_of_voxels(voxels);
    const HalfEdges half_edges = build_half_edges(ball);
    const std::vector<vec3> normals = rounded_normals(ball, half_edges);
    const Creases found = creases_of(ball, half_edges);
    EXPECT_EQ(found.edges.size(), 72u) << "twelve at each pole, of " << voxels << " voxels";
    EXPECT_EQ(creases_that_count(ball, half_edges, found, normals, 0.5 * voxels).edges.size(), 0u) << voxels << " voxels";
    EXPECT_EQ(creases_that_count(ball, half_edges, found, normals, 0.5), found) << "at half a voxel";
  }
}

TEST(CountingCreases, do_not_count_on_a_smooth_surface_unless_they_are_marked) {
  Triangles ball = read_triangles(input_of(sphere(1, {.vertices = 3000})));
  const HalfEdges half_edges = build_half_edges(ball);
  const auto first = [&](int32_t half_edge) { return std::min(half_edge, half_edges.twin[half_edge]); };
  const Creases creases = creases_along(half_edges, {first(300), first(600)});
  const std::vector<vec3> normals = rounded_normals(ball, half_edges);
  EXPECT_EQ(creases_that_count(ball, half_edges, creases, normals, 0.2).edges.size(), 0);
  ball.half_edge_sharp[300] = ball.half_edge_sharp[half_edges.twin[300]] = 1;
  const Creases one = creases_that_count(ball, half_edges, creases, normals, 0.2);
  EXPECT_EQ(one.edges, std::vector{first(300)});
  EXPECT_TRUE(one.contains(300));
  EXPECT_FALSE(one.contains(600));
}

} // namespace
} // namespace paradesc::test
