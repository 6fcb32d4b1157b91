// The paper's object-space method, for times to compare with: mean curvature (8) by sums over the Voronoi-weighted vertices
// within the ball, found by a flood from vertex to vertex over the half-edges.
//
// As fast as this method gets: flat arrays in the order of a space-filling curve, stamps instead of a set of visited vertices,
// nothing allocated at a vertex, no branch that cannot be foretold in the inner loops, all cores.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc::bench {

struct alignas(16) WeightedPoint {
  float x, y, z, area;
};

// Is made once, outside the measured time. Points are renumbered along a space-filling curve.
struct BaselineSurface {
  std::vector<WeightedPoint> points;
  std::vector<vec3> normals;       // (points)
  std::vector<int32_t> ring_begin; // (points + 1) into ring
  std::vector<int32_t> ring;       // the points that an edge leads to
  std::vector<int32_t> origin;     // (points) number among HalfEdges' points
};

// point_normals: (point_count) unit.
BaselineSurface build_baseline(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> point_normals);

// (point_count) Meyer's mixed Voronoi area of every point.
std::vector<float> voronoi_areas(const Triangles &triangles, const HalfEdges &half_edges);

struct BaselineRun {
  int64_t neighbors = 0;    // found, of all points asked for
  double seconds = 0.0;     // by the clock
  double cpu_seconds = 0.0; // of all cores, which other programs disturb less
};

// H at the points asked for, numbers of BaselineSurface, into values at the same places; NaN where there is no neighbor.
BaselineRun run_baseline(const BaselineSurface &surface, double radius, std::span<const int32_t> requested, int threads,
                         std::span<float> values);

// About `count` points in runs of 64 neighbors on the curve, as a whole run meets them; all where there are not more.
std::vector<int32_t> choose_points(const BaselineSurface &surface, int count, uint32_t seed);

} // namespace paradesc::bench
