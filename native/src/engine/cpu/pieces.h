// Pieces of the surface: triangles, parts of them and clusters of them, as sums over neighborhoods take them.
#pragma once

#include "support/math.h"

namespace paradesc {

// A triangle whose normals vary linearly over it, or what is like one: with a and b as uncorrelated as they come, each of mean 0
// and variance 1, its surface lies at position + a along[0] + b along[1] and has the normal that goes with it.
struct Sample {
  vec3 position{0.0f};
  vec3 along[2] = {vec3(0.0f), vec3(0.0f)};
  vec3 normal{0.0f}; // mean: shorter than 1 where the surface turns
  vec3 normal_along[2] = {vec3(0.0f), vec3(0.0f)};
  vec3 face{0.0f}; // mean of the triangles' own normals, likewise
  float area = 0;
  float reach = 0; // no point of it is farther from its position
  float turn = 0;  // no triangle of it, or around it, leans from face by an angle of a larger tangent
  float noise = 0; // variance along the normal; NaN where it is not known
  float facet = 0; // area of the triangle it is of, or mean of those
};

// corners, normals: at each of three, in turning order; between them normals have the directions of what is linear. lean: how far
// no normal of the triangles around is from its own, as points of the unit sphere.
Sample sample_of_triangle(const vec3 *corners, const vec3 *normals, float lean = 0.0f);

// What a connected piece of many triangles comes to.
struct Cluster {
  vec3 position{0.0f};
  vec3 normal{0.0f};
  vec3 face{0.0f};
  float area = 0;
  float noise = 0, facet = 0; // likewise
  float reach = 0;            // no point of it is farther from its position
  mat3 variance{0.0f};        // of positions
  mat3 normal_variance{0.0f}; // of normals (rows) with positions (columns)
};

// Adds up triangles. origin: some place near them.
class ClusterSums {
public:
  explicit ClusterSums(vec3 origin) : origin_(origin) {}
  void add(const Sample &triangle);
  Cluster cluster() const; // but for its reach

private:
  vec3 origin_;
  Cluster sums_;
};

// The triangle that stands for a cluster. lean: as that of a triangle, from its mean face.
Sample sample_of(const Cluster &cluster, float lean);

} // namespace paradesc
