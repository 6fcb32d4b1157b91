// Triangles → a tree of boxes → for a ray, the triangle that it meets nearest to its point.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "support/math.h"

namespace paradesc {

// The hit of a ray; triangle is -1 if there is none.
struct RayHit {
  int32_t triangle = -1;
  double distance = 0; // along the direction, below 0 behind the point
  std::array<double, 3> weights{};
};

// Returns whether hit a comes before hit b. At equal distances the one ahead of the point comes first, then the lower triangle.
bool is_nearer(const RayHit &a, const RayHit &b);

// A ray in its own coordinates, in which it is the third axis (Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection",
// 2013). The side on which it passes an edge depends on the edge's two ends alone, so both triangles of the edge agree about
// that side.
class Ray {
public:
  // The direction must not be zero, and all numbers must be finite.
  Ray(dvec3 point, dvec3 direction);

  // Intersects the triangle, on either side of the ray's point, if the triangle's outside faces along the direction.
  RayHit meet(int32_t triangle, dvec3 a, dvec3 b, dvec3 c) const;

  const dvec3 &point() const { return point_; }
  const dvec3 &inverse() const { return inverse_; } // of the direction, huge in place of infinite

private:
  dvec3 sheared(dvec3 position) const;

  dvec3 point_, inverse_;
  int x_, y_, z_; // axes; z_ is the direction's largest
  double shear_x_, shear_y_, scale_;
};

// The arrays passed to the constructor are borrowed.
class RayTree {
public:
  RayTree(std::span<const float> positions, std::span<const int32_t> triangle_vertices, int threads);

  // The nearest hit at a distance of at most `reach` from the ray's point.
  RayHit nearest(const Ray &ray, double reach) const;

private:
  struct Node {
    std::array<float, 3> low, high;
    int32_t first, count; // range in order_ and corners_; count 0: an inner node, first is the first of its two children
  };

  dvec3 position(int32_t triangle, int corner) const;
  bool has_place(int32_t triangle) const;
  void bound(Node &node) const;
  void split(const Node &node, const std::vector<vec3> &middles);
  // Bounds the nodes from index `level` on and appends their children; returns the index of the first child.
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
