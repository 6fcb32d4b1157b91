// Pieces of the surface: triangles, parts of them and clusters of them, as sums over neighborhoods take them.
#pragma once

#include <span>

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
  float reach = 0; // no point of it is farther from its position; nor, in the plane of face, from the way through it along a
                   // normal of its surface that starts as high above that plane as its position
  float turn = 0;  // no triangle of it, or around it, leans from face by an angle of a larger tangent
  // Mean squared distance from the position.
  float spread() const { return dot(along[0], along[0]) + dot(along[1], along[1]); }
};

// corners, normals: at each of three, in turning order; the normals are unit. lean: how far no normal of the triangles around is
// from its own, as points of the unit sphere.
Sample sample_of_triangle(const vec3 *corners, const vec3 *normals, float lean);

// What a connected piece of many triangles comes to.
struct Cluster {
  vec3 position{0.0f};
  vec3 normal{0.0f};
  vec3 face{0.0f};
  float area = 0;
  float reach = 0;     // no point of it is farther from its position
  float lean = 0;      // no triangle of it, or around it, has a normal farther from that of face, as points of the unit sphere
  mat3 variance{0.0f}; // of positions
  mat3 normal_variance{0.0f}; // of normals (rows) with positions (columns)
  float spread() const { return variance[0][0] + variance[1][1] + variance[2][2]; }
};

Cluster cluster_of(const Sample &triangle, float lean);
Cluster join(std::span<const Cluster> parts);
// The triangle that stands for a cluster.
Sample sample_of(const Cluster &cluster);

} // namespace paradesc
