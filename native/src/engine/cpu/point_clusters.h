// Points and a radius → clusters of points that are small against the radius, whose triangles are summed as one.
#pragma once

#include <span>
#include <vector>

#include "engine/cpu/point_patches.h"
#include "support/math.h"

namespace paradesc {

struct ClusterLimit {
  float spread;    // mean squared distance of the points from their middle; half of the squared length of edges from them
  float coherence; // least squared length of their mean normals, so that a cluster hides no detail
};

// The points of a mesh.
struct PointSurface {
  std::span<const vec3> position; // (points)
  std::span<const vec3> normal;   // (points) unit normals
  std::span<const vec3> facing;   // (points) mean normals of the faces around, shorter than 1 where they differ; or empty
};

// Returns where the points of each node begin, for build_point_patches().
std::vector<int32_t> plan_nodes(const PointOrder &order, const PointSurface &surface, const ClusterLimit &limit, int threads);

} // namespace paradesc
