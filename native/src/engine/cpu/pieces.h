// Pieces of the surface over which neighborhoods are summed: triangles, parts of triangles, and clusters of triangles.
#pragma once

#include "support/math.h"

namespace paradesc {

// A triangle with linearly varying normals, or an equivalent of one. With uncorrelated a and b of mean 0 and variance 1, its
// points are position + a along[0] + b along[1], and the normals there are normal + a normal_along[0] + b normal_along[1].
struct Sample {
  vec3 position{0.0f};
  vec3 along[2] = {vec3(0.0f), vec3(0.0f)};
  vec3 normal{0.0f}; // mean; shorter than 1 where the surface turns
  vec3 normal_along[2] = {vec3(0.0f), vec3(0.0f)};
  vec3 face{0.0f}; // mean of the triangles' face normals; shorter than 1 where they differ
  float area = 0;
  float noise = 0; // variance along the normal; NaN if unknown
  float facet = 0; // area of its triangle, or area-weighted mean for several
};

// corners, normals: of the triangle, in orientation order. Normals are interpolated linearly and then normalized.
Sample sample_of_triangle(const vec3 *corners, const vec3 *normals);

// Sums over a connected piece of many triangles.
struct Cluster {
  vec3 position{0.0f};
  vec3 normal{0.0f};
  vec3 face{0.0f};
  float area = 0;
  float noise = 0, facet = 0; // as for a Sample
  float reach = 0;            // bound on the distance of its points from position
  mat3 variance{0.0f};        // covariance of positions
  mat3 normal_variance{0.0f}; // covariance of normals (rows) with positions (columns)
};

// Sums triangles. origin: a point near them.
class ClusterSums {
public:
  explicit ClusterSums(vec3 origin) : origin_(origin) {}
  void add(const Sample &triangle);
  Cluster cluster() const; // without its reach

private:
  vec3 origin_;
  Cluster sums_;
};

// Returns the triangle that represents a cluster.
Sample sample_of(const Cluster &cluster);

} // namespace paradesc
