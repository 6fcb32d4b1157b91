// Points → the area of the surface that is connected to each within the ball, by vertices: to a few per cent what floods over
// triangles find (connected_triangles.h), for a fraction of the time where triangles are many and small.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/patches.h"
#include "mesh/triangles.h"
#include "support/pool.h"

namespace paradesc {

class PatchFlood;

// The patches as the positions have them, in their units.
struct MeasuredPatches {
  std::vector<vec4> point;    // as Patches::point: position, a third of all triangles there
  std::vector<vec4> sphere;   // (patches) middle, radius
  std::vector<float> largest; // (patches) area of a triangle
};

class PatchAreas {
public:
  PatchAreas(const Patches &patches, const HalfEdges &half_edges, const Triangles &triangles, double radius, int threads);
  ~PatchAreas();
  // (points) Below 0 where triangles are too large against the radius to tell.
  std::vector<double> run(std::span<const int32_t> points);

private:
  std::vector<size_t> put_side_by_side(std::span<const int32_t> points, std::span<int32_t> order) const;

  const Patches &patches_;
  const HalfEdges &half_edges_;
  const Triangles &triangles_;
  double radius_;
  int threads_;
  MeasuredPatches measured_;
  Pool<PatchFlood> floods_;
};

} // namespace paradesc
