// Triangles → a tree of boxes → for a ray, the triangle that it meets nearest to its point.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "support/math.h"

namespace paradesc {

// What is met: none where triangle is -1.
struct RayHit {
  int32_t triangle = -1;
  double distance = 0; // along the direction, below 0 behind the point
  std::array<double, 3> weights{};
};

// Whether a is what a ray meets first: of two at one distance the one ahead counts, then that of the lower number.
bool is_nearer(const RayHit &a, const RayHit &b);

// A ray in coordinates of its own, in which it is the third axis (Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection",
// 2013). What it sees of an edge depends on the two ends alone, so both triangles beside an edge agree on which side of it the
// ray passes.
class Ray {
public:
  // The direction must have a length, and all numbers be finite.
  Ray(dvec3 point, dvec3 direction);

  // Where it meets the triangle on either side of its point, if the triangle's outside faces along its direction.
  RayHit meet(int32_t triangle, dvec3 a, dvec3 b, dvec3 c) const;

  const dvec3 &point() const { return point_; }
  const dvec3 &inverse() const { return inverse_; } // of the direction, huge in place of infinite

private:
  dvec3 sheared(dvec3 position) const;

  dvec3 point_, inverse_;
  int x_, y_, z_; // the axes, of which z_ is the direction's largest
  double shear_x_, shear_y_, scale_;
};

// The arrays are borrowed.
class RayTree {
public:
  RayTree(std::span<const float> positions, std::span<const int32_t> triangle_vertices, int threads);

  // What the ray meets at most so far from its point.
  RayHit nearest(const Ray &ray, double reach) const;

private:
  struct Node {
    std::array<float, 3> low, high;
    int32_t first, count; // of the triangles in order_ and corners_; count 0: first is the node of the first of two children
  };

  dvec3 position(int32_t triangle, int corner) const;
  bool has_place(int32_t triangle) const;
  void bound(Node &node) const;
  void split(const Node &node, const std::vector<vec3> &middles);
  // Bounds the nodes from this one on and appends their children; gives the first of these.
  size_t divide(size_t level, const std::vector<vec3> &middles, int threads);
  void meet_all(const Node &node, const Ray &ray, double reach, RayHit &best) const;

  std::span<const float> positions_;
  std::span<const int32_t> vertices_;
  std::vector<int32_t> order_;               // triangles that have a place
  std::vector<std::array<vec3, 3>> corners_; // of these
  std::vector<Node> nodes_;
  double largest_ = 0; // of all coordinates
};

} // namespace paradesc
