// The triangles that are connected to a center within a ball, as the device finds them, and their area.
#include "engine/opengl/connected_triangles.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "mesh/ball_flood.h"
#include "support/on_device.h"
#include "support/solids.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

// A strip of squares, folded like a hairpin: two legs of `length` squares, a gap apart, joined by one square across their end.
struct Hairpin {
  static constexpr int length = 20;
  static constexpr float gap = 0.5f; // squares have side 1
  static Triangles triangles() {
    const int rows = 2 * (length + 1);
    std::vector<vec3> positions;
    for (int row = 0; row < rows; ++row)
      for (int side = 0; side < 2; ++side) {
        const bool back = row > length;
        positions.emplace_back(back ? rows - 1 - row : row, side, back ? gap : 0.0f);
      }
    std::vector<int32_t> corners;
    for (int32_t row = 0; row + 1 < rows; ++row)
      corners.insert(corners.end(), {2 * row, 2 * row + 2, 2 * row + 1, 2 * row + 1, 2 * row + 2, 2 * row + 3});
    return shape(positions, corners);
  }
  static int32_t vertex_at(int row) { return 2 * row; }
};

// Flat squares of side 1, each cut in two, whose vertices are moved at random.
struct UnevenPlane {
  static constexpr int side = 40; // squares
  static Triangles triangles() {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> moved(-0.3f, 0.3f);
    std::vector<vec3> positions;
    for (int y = 0; y <= side; ++y)
      for (int x = 0; x <= side; ++x) {
        const float across = static_cast<float>(x) + moved(random), along = static_cast<float>(y) + moved(random);
        positions.emplace_back(across, along, 0.0f);
      }
    std::vector<int32_t> corners;
    for (int32_t y = 0; y < side; ++y)
      for (int32_t x = 0; x < side; ++x) {
        const int32_t at = y * (side + 1) + x;
        corners.insert(corners.end(), {at, at + 1, at + side + 1, at + side + 1, at + 1, at + side + 2});
      }
    return shape(positions, corners);
  }
  // At least 15 squares from its border.
  static std::vector<int32_t> vertices_inside() {
    std::vector<int32_t> vertices;
    for (int32_t y = 15; y <= side - 15; ++y)
      for (int32_t x = 15; x <= side - 15; ++x) vertices.push_back(y * (side + 1) + x);
    return vertices;
  }
};

class ConnectedTrianglesOnDevice : public OnDevice {
protected:
  void take(Triangles list) {
    triangles = std::move(list);
    half_edges = build_half_edges(triangles);
  }

  struct Found {
    std::vector<int32_t> vertices;               // that are computed again
    std::vector<std::vector<int32_t>> triangles; // connected to each of them, sorted
    int patches = 0;                             // that a flood came to at most
  };

  // sampled: the area that every center's samples found; those that the triangles have within the tolerance are not computed
  // again.
  Found check(const std::vector<int32_t> &vertices, double radius, double sampled = -1e9, double tolerance = 0.0,
              int expected_patches = 1) {
    const BakeSpace space = bake_space_of(bounding_box(triangles, half_edges));
    const Patches patches = build_patches(half_edges);
    const int count = static_cast<int>(vertices.size());
    std::vector<CenterData> centers(vertices.size());
    std::vector<int32_t> codes, all(vertices.size());
    for (size_t i = 0; i < vertices.size(); ++i) {
      const int32_t point = half_edges.vertex_point[static_cast<size_t>(vertices[i])];
      centers[i].position = space.to_buffer(triangles.positions[static_cast<size_t>(vertices[i])]);
      codes.push_back(patches.code[static_cast<size_t>(half_edges.point_half_edge[static_cast<size_t>(point)] / 3)]);
      all[i] = static_cast<int32_t>(i);
    }
    const auto to_buffer = static_cast<float>(space.scale);
    std::vector<float> results((ROW_AREA + 1) * vertices.size(), static_cast<float>(sampled) * to_buffer * to_buffer);
    Found found;
    thread->run([&](const Gl &gl, ProgramCache &programs) {
      DeviceSurface surface;
      surface.set_positions(gl, triangles, space, 0);
      ConnectedTriangles connected;
      connected.set_mesh(gl, triangles, half_edges, patches);
      connected.measure(gl, programs, surface);
      connected.set_starts(gl, codes);
      connected.expect(expected_patches);
      Buffer center_buffer, result_buffer, params_buffer;
      center_buffer.upload(gl, centers);
      result_buffer.upload(gl, results);
      std::vector<int32_t> list;
      for (bool fits = false; !fits;) {
        found = {};
        connected.begin(gl, count, std::max(count, 1));
        gl.NamedBufferSubData(connected.list(), CONNECTED_AMBIGUOUS * sizeof(int32_t), sizeof count, &count);
        gl.NamedBufferSubData(connected.list(), CONNECTED_HEADER * sizeof(int32_t),
                              count * static_cast<GLsizeiptr>(sizeof(int32_t)), all.data());
        for (int first = 0; first < count; first += connected.slots()) {
          EvaluateParams params{};
          params.first = first;
          params.last = std::min(count, first + connected.slots());
          params.total = count;
          params.radius = static_cast<float>(radius * space.scale);
          params.slots = connected.slots();
          params.flood_table = connected.flood_table();
          params.area_tolerance = static_cast<float>(tolerance / (radius * radius));
          params_buffer.fill(gl, &params, sizeof params, GL_STREAM_DRAW);
          gl.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_EVALUATE, params_buffer.id());
          gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_CENTERS, center_buffer.id());
          gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_RESULTS, result_buffer.id());
          connected.flood(gl, programs, surface, params.last - params.first);
          const int table = connected.flood_table(), slots = connected.slots();
          list.resize(static_cast<size_t>(CONNECTED_HEADER + count + slots * (1 + 2 * table)));
          gl.GetNamedBufferSubData(connected.list(), 0, static_cast<GLsizeiptr>(list.size() * sizeof(int32_t)), list.data());
          check_gl(gl, "read-back");
          found.patches = list[CONNECTED_PATCHES];
          for (int i = 0; i < list[CONNECTED_AGAIN]; ++i)
            add(found, vertices[at(list[at(CONNECTED_HEADER + count + i)])],
                {&list[at(CONNECTED_HEADER + count + slots + 2 * table * i)], at(2 * table)}, patches);
        }
        fits = connected.make_room(found.patches);
      }
    });
    return found;
  }

  // What a processor reaches.
  std::vector<int32_t> expected(int32_t vertex, double radius) const {
    BallFlood flood(triangles, half_edges);
    flood.start_at_point(dvec3(triangles.positions[at(vertex)]), half_edges.vertex_point[at(vertex)]);
    flood.grow(radius);
    std::vector<int32_t> reached = flood.triangles();
    std::ranges::sort(reached);
    return reached;
  }

  std::vector<int32_t> reached(int32_t vertex, double radius) {
    const Found found = check({vertex}, radius);
    return found.triangles.empty() ? std::vector<int32_t>() : found.triangles[0];
  }

  void expect_the_processors(const std::vector<int32_t> &vertices, double radius) {
    const Found found = check(vertices, radius);
    ASSERT_EQ(found.vertices.size(), vertices.size()) << radius;
    constexpr double rounding = 2e-6; // of floats: by so much, a ball may meet an edge or not
    for (size_t i = 0; i < vertices.size(); ++i) {
      const int32_t vertex = found.vertices[i];
      ASSERT_TRUE(std::ranges::includes(found.triangles[i], expected(vertex, radius * (1.0 - rounding))))
          << vertex << ", " << radius;
      ASSERT_TRUE(std::ranges::includes(expected(vertex, radius * (1.0 + rounding)), found.triangles[i]))
          << vertex << ", " << radius;
    }
  }

  static size_t at(int32_t index) { return static_cast<size_t>(index); }

  Triangles triangles;
  HalfEdges half_edges;

private:
  static void add(Found &found, int32_t vertex, std::span<const int32_t> table, const Patches &patches) {
    std::vector<int32_t> list;
    for (size_t i = 0; i < table.size(); i += 2)
      for (int32_t bit = 0; table[i] >= 0 && bit < PATCH_TRIANGLES; ++bit) {
        const int32_t triangle = patches.triangle[at(PATCH_TRIANGLES * table[i] + bit)];
        if (triangle >= 0 && (static_cast<uint32_t>(table[i + 1]) >> bit & 1)) list.push_back(triangle);
      }
    std::ranges::sort(list);
    found.vertices.push_back(vertex);
    found.triangles.push_back(list);
  }
};

// The other leg is nearer than the radius all along, but the way to it leads around the end.
TEST_F(ConnectedTrianglesOnDevice, leave_out_the_other_leg_of_a_hairpin_far_from_its_end) {
  take(Hairpin::triangles());
  const std::vector<int32_t> found = reached(Hairpin::vertex_at(10), 3.0);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(found.back(), 2 * Hairpin::length) << "triangles are numbered along the strip";
  // Squares 7 to 12 lie within 3 of row 10, and those beside them meet the ball in an edge at most.
  for (const int square : {7, 8, 9, 10, 11, 12})
    for (const int triangle : {2 * square, 2 * square + 1}) EXPECT_TRUE(std::ranges::binary_search(found, triangle)) << triangle;
  EXPECT_GE(found.front(), 2 * 6);
  EXPECT_LE(found.back(), 2 * 13 + 1);
}

TEST_F(ConnectedTrianglesOnDevice, reach_the_other_leg_around_the_end) {
  take(Hairpin::triangles());
  const std::vector<int32_t> found = reached(Hairpin::vertex_at(Hairpin::length - 1), 3.0);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(std::ranges::binary_search(found, 2 * Hairpin::length)); // across
  EXPECT_GT(found.back(), 2 * Hairpin::length + 2);                    // and back
}

// A point before a long edge whose ends lie far outside of the ball; behind it another triangle, and behind that one a third.
TEST_F(ConnectedTrianglesOnDevice, lie_behind_an_edge_that_passes_through_the_ball) {
  take(shape({{0, 0, 0}, {-5, 0.5f, 0}, {5, 0.5f, 0}, {0, 6, 0}, {9, 6, 0}}, {0, 2, 1, 1, 2, 3, 3, 2, 4}));
  EXPECT_EQ(reached(0, 1.0), (std::vector<int32_t>{0, 1}));
}

// Every room that floods have, on triangles of all sizes against the radius, whole patches among them.
TEST_F(ConnectedTrianglesOnDevice, are_those_that_the_processor_finds) {
  take(read_triangles(input_of(torus(1.0, 0.4, {.vertices = 6000}))));
  std::vector<int32_t> some;
  for (int32_t vertex = 0; vertex < triangles.vertex_count; vertex += 17) some.push_back(vertex);
  std::set<int> rooms;
  for (const double radius : {0.01, 0.05, 0.1, 0.2, 0.45, 0.9, 1.5}) {
    expect_the_processors(some, radius);
    rooms.insert(check({0}, radius).patches);
  }
  EXPECT_LT(*rooms.begin(), 5);
  EXPECT_GT(*rooms.rbegin(), 128);
  take(Hairpin::triangles());
  some.clear();
  for (int row = 0; row < 2 * Hairpin::length; ++row) some.push_back(Hairpin::vertex_at(row));
  for (const double radius : {0.7, 2.5, 5.0}) expect_the_processors(some, radius);
}

// One over it is no number: a center is not even near itself.
TEST_F(ConnectedTrianglesOnDevice, are_none_in_a_radius_below_all_floats) {
  take(Hairpin::triangles());
  EXPECT_TRUE(reached(Hairpin::vertex_at(10), 1e-45).empty());
}

TEST_F(ConnectedTrianglesOnDevice, that_are_too_many_are_left_to_the_samples) {
  take(read_triangles(input_of(torus(1.0, 0.4, {.vertices = 12000}))));
  const Found found = check({0}, 3.0); // all of it
  EXPECT_TRUE(found.vertices.empty());
  EXPECT_GT(found.patches, 512);
}

// All four ways: small triangles whose rim is straight, large ones, whole patches, and disks within one triangle.
TEST_F(ConnectedTrianglesOnDevice, have_the_area_of_disks_on_a_plane_whatever_the_size_of_triangles) {
  take(UnevenPlane::triangles());
  const std::vector<int32_t> vertices = UnevenPlane::vertices_inside();
  for (const double radius : {14.0, 8.0, 5.0, 3.0, 2.0, 1.0, 0.5, 0.1}) {
    const double disk = pi * radius * radius;
    EXPECT_EQ(check(vertices, radius, disk, 0.006 * disk).vertices.size(), 0u) << radius;
    EXPECT_EQ(check(vertices, radius, 1.02 * disk, 0.006 * disk).vertices.size(), vertices.size()) << radius;
    EXPECT_EQ(check(vertices, radius, 0.98 * disk, 0.006 * disk).vertices.size(), vertices.size()) << radius;
  }
}

// Three quarters of a disk at a corner, a whole one beside an edge that the ball reaches over, in triangles far larger than the
// ball.
TEST_F(ConnectedTrianglesOnDevice, have_the_area_of_disks_bent_over_the_edges_of_a_box) {
  take(box(2));
  int32_t corner = -1, on_edge = -1;
  for (int32_t vertex = 0; vertex < triangles.vertex_count; ++vertex) {
    const vec3 position = triangles.positions[at(vertex)];
    if (position == vec3(1, 1, 1)) corner = vertex;
    if (position == vec3(1, 1, 0)) on_edge = vertex;
  }
  ASSERT_GE(std::min(corner, on_edge), 0);
  for (const double radius : {0.8, 0.2, 0.01}) {
    const double disk = pi * radius * radius;
    EXPECT_TRUE(check({on_edge}, radius, disk, 1e-4 * disk).vertices.empty()) << radius;
    EXPECT_TRUE(check({corner}, radius, 0.75 * disk, 1e-4 * disk).vertices.empty()) << radius;
    EXPECT_FALSE(check({corner, on_edge}, radius, 0.9 * disk, 0.05 * disk).vertices.empty()) << radius;
  }
}

TEST_F(ConnectedTrianglesOnDevice, are_the_same_whatever_room_was_expected) {
  take(read_triangles(input_of(torus(1.0, 0.4, {.vertices = 3000}))));
  const Found few = check({5, 70, 900}, 0.2), many = check({5, 70, 900}, 0.2, -1e9, 0.0, 500);
  EXPECT_LE(few.patches, 128);
  ASSERT_EQ(few.vertices.size(), 3u);
  ASSERT_EQ(many.vertices.size(), 3u);
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k)
      EXPECT_TRUE(few.vertices[i] != many.vertices[k] || few.triangles[i] == many.triangles[k]) << few.vertices[i];
}

} // namespace
} // namespace paradesc::test
