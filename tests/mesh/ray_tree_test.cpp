// The hits of rays agree with closed forms, and to the bit with a plain search over all triangles, also through edges and
// vertices.
#include "mesh/ray_tree.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "support/cancel.h"
#include "support/error.h"
#include "support/surfaces.h"

namespace paradesc::test {
namespace {

struct Soup {
  std::vector<float> positions{};
  std::vector<int32_t> vertices{};

  void add(dvec3 a, dvec3 b, dvec3 c) {
    for (const dvec3 &at : {a, b, c}) {
      vertices.push_back(static_cast<int32_t>(positions.size() / 3));
      for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(at[axis]));
    }
  }
  dvec3 at(int32_t triangle, int corner) const {
    const float *found = positions.data() + 3 * vertices[static_cast<size_t>(3 * triangle + corner)];
    return {found[0], found[1], found[2]};
  }
  int32_t triangles() const { return static_cast<int32_t>(vertices.size() / 3); }
  RayTree tree(int threads = 1) const { return {positions, vertices, threads}; }
};

// All triangles, one after the other.
RayHit searched(const Soup &soup, const Ray &ray, double reach) {
  RayHit best;
  for (int32_t t = 0; t < soup.triangles(); ++t) {
    const RayHit hit = ray.meet(t, soup.at(t, 0), soup.at(t, 1), soup.at(t, 2));
    if (hit.triangle >= 0 && std::abs(hit.distance) <= reach && is_nearer(hit, best)) best = hit;
  }
  return best;
}

void expect_same(const RayHit &found, const RayHit &expected) {
  EXPECT_EQ(found.triangle, expected.triangle);
  EXPECT_EQ(found.distance, expected.distance);
  EXPECT_EQ(found.weights, expected.weights);
}

dvec3 somewhere(Random &random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

// Outward faces of a box about the origin, two triangles each.
Soup box(dvec3 half) {
  Soup soup;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      dvec3 normal(0), along(0), across(0);
      normal[axis] = side * half[axis];
      along[(axis + 1) % 3] = half[(axis + 1) % 3];
      across[(axis + 2) % 3] = side * half[(axis + 2) % 3];
      soup.add(normal - along - across, normal + along - across, normal + along + across);
      soup.add(normal - along - across, normal + along + across, normal - along + across);
    }
  return soup;
}

Soup soup_of(const TestMesh &mesh) { return {mesh.positions, mesh.corner_vertices}; }

} // namespace

TEST(RayTree, rays_from_the_middle_meet_a_sphere_at_its_radius) {
  const Soup soup = soup_of(sphere(2.0, {.vertices = 20000}));
  const RayTree tree = soup.tree();
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const dvec3 direction = glm::normalize(somewhere(random, 1.0));
    const RayHit hit = tree.nearest(Ray(dvec3(0), direction), 3.0);
    ASSERT_GE(hit.triangle, 0);
    // Faces lie below the sphere by a hundredth of an edge's square over the radius, at most.
    EXPECT_NEAR(hit.distance, 2.0, 2e-3);
    EXPECT_LE(hit.distance, 2.0 + 1e-6);
    dvec3 place(0);
    for (int corner = 0; corner < 3; ++corner) place += hit.weights[static_cast<size_t>(corner)] * soup.at(hit.triangle, corner);
    EXPECT_NEAR(glm::length(place - hit.distance * direction), 0.0, 1e-12);
  }
}

TEST(RayTree, the_nearer_side_of_a_box_is_met_ahead_or_behind) {
  const RayTree tree = box({1, 2, 3}).tree();
  const auto distance = [&](dvec3 point, dvec3 direction, double reach) {
    const RayHit hit = tree.nearest(Ray(point, direction), reach);
    return hit.triangle < 0 ? std::numeric_limits<double>::infinity() : hit.distance;
  };
  EXPECT_DOUBLE_EQ(distance({0.25, 0.125, 0}, {5, 0, 0}, 10), 0.75);   // directions of any length
  EXPECT_DOUBLE_EQ(distance({1.5, 0.125, 0.25}, {1, 0, 0}, 10), -0.5); // behind the point
  EXPECT_DOUBLE_EQ(distance({-1.5, 0.125, 0.25}, {1, 0, 0}, 10), 2.5); // not the side that faces the other way
  EXPECT_DOUBLE_EQ(distance({0.25, 0.125, 0}, {0, 0, -1}, 10), 3.0);
  EXPECT_EQ(distance({1.5, 0.125, 0.25}, {1, 0, 0}, 0.499), std::numeric_limits<double>::infinity()); // out of reach
  EXPECT_EQ(distance({1.5, 2.5, 0.25}, {1, 0, 0}, 10), std::numeric_limits<double>::infinity());      // past it
  EXPECT_DOUBLE_EQ(distance({1, 0.125, 0.25}, {1, 0, 0}, 10), 0.0);                                   // on it
}

TEST(RayTree, finds_to_the_bit_what_a_search_over_all_triangles_finds) {
  Random random(2);
  int met = 0;
  for (const double size : {1.0, 1e-3, 1e4}) {
    Soup soup;
    for (int i = 0; i < 500; ++i) {
      const dvec3 middle = somewhere(random, size);
      soup.add(middle + somewhere(random, 0.3 * size), middle + somewhere(random, 0.3 * size),
               middle + somewhere(random, 0.3 * size));
    }
    const RayTree tree = soup.tree(2);
    for (int i = 0; i < 1500; ++i) {
      dvec3 direction = somewhere(random, 1.0);
      if (i % 5 == 0) direction = dvec3(i % 3 == 0, i % 3 == 1, i % 3 == 2); // along an axis
      if (i % 10 == 0) direction = -direction;
      const Ray ray(somewhere(random, 1.2 * size), direction);
      const RayHit expected = searched(soup, ray, 0.7 * size);
      expect_same(tree.nearest(ray, 0.7 * size), expected);
      met += expected.triangle >= 0;
    }
  }
  EXPECT_GT(met, 1500);
  EXPECT_LT(met, 4400);
}

TEST(RayTree, triangles_without_area_or_with_coordinates_that_are_none_are_never_met) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN(), huge = std::numeric_limits<float>::infinity();
  Soup soup;
  soup.add({0, 0, 1}, {1, 0, 1}, {2, 0, 1}); // a line
  soup.add({0, 0, 1}, {0, 0, 1}, {0, 0, 1}); // a point
  soup.add({-1, -1, 1}, {1, -1, 1}, {0, none, 1});
  soup.add({-1, -1, 1}, {1, -1, 1}, {0, huge, 1});
  EXPECT_EQ(soup.tree().nearest(Ray({0.5, 0, 0}, {0, 0, 1}), 9).triangle, -1);
  soup.add({-1, -1, 2}, {1, -1, 2}, {0, 1, 2});
  EXPECT_EQ(soup.tree().nearest(Ray({0, 0, 0}, {0, 0, 1}), 9).triangle, 4);
  EXPECT_EQ(Soup().tree().nearest(Ray({0, 0, 0}, {0, 0, 1}), 9).triangle, -1);
}

TEST(RayTree, of_two_at_one_distance_the_one_ahead_counts_then_the_lower_number) {
  Soup soup;
  for (const double z : {-1.0, 1.0, 1.0, -1.0}) soup.add({-1, -1, z}, {1, -1, z}, {0, 1, z});
  EXPECT_EQ(soup.tree().nearest(Ray({0, 0, 0}, {0, 0, 1}), 9).triangle, 1);
}

// Rays through edges and vertices, and a rounding beside them, from many sides.
TEST(RayTree, no_ray_slips_between_triangles) {
  Random random(3);
  const TestMesh mesh = sphere(1.0, {.vertices = 300});
  const Soup soup = soup_of(mesh);
  const RayTree tree = soup.tree();
  for (int i = 0; i < 20000; ++i) {
    const auto triangle = static_cast<int32_t>(random.uniform() * soup.triangles());
    const double share = i % 3 == 0 ? 0.0 : random.uniform();
    const dvec3 on_edge = soup.at(triangle, 0) + share * (soup.at(triangle, 1) - soup.at(triangle, 0));
    const dvec3 inside = somewhere(random, 0.3);
    const RayHit hit = tree.nearest(Ray(inside, on_edge - inside), 3.0);
    ASSERT_GE(hit.triangle, 0) << i;
    EXPECT_NEAR(hit.distance, glm::length(on_edge - inside), 1e-6);
  }
}

TEST(RayTree, far_from_the_origin_rays_still_meet_a_plane_of_triangles) {
  Soup soup;
  const double step = 0.125;
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y) {
      const dvec3 low(1e5 + x * step, -1e5 + y * step, 4096);
      soup.add(low, low + dvec3(step, 0, 0), low + dvec3(step, step, 0));
      soup.add(low, low + dvec3(step, step, 0), low + dvec3(0, step, 0));
    }
  const RayTree tree = soup.tree();
  Random random(4);
  for (int i = 0; i < 5000; ++i) {
    const dvec3 under(1e5 + random.uniform(0.1, 2.4), -1e5 + random.uniform(0.1, 2.4), 4095);
    EXPECT_DOUBLE_EQ(tree.nearest(Ray(under, {0, 0, 1}), 2).distance, 1.0);
  }
}

TEST(RayTree, building_ends_where_the_caller_says_stop) {
  const Soup soup = soup_of(sphere(1.0, {.vertices = 5000}));
  const std::chrono::milliseconds patience = cancel_patience;
  cancel_patience = std::chrono::milliseconds(0);
  int calls = 0;
  {
    const CancelScope scope([&] {
      if (++calls == 3) throw Error(PDESC_ERROR_CANCELLED, "Cancelled.");
    });
    EXPECT_THROW(soup.tree(2), Error);
  }
  cancel_patience = patience;
  EXPECT_EQ(calls, 3);
}

} // namespace paradesc::test
