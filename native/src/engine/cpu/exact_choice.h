// A pass → whether its sums are those over all triangles (engine/cpu/exact_pass) or over samples.
#pragma once

#include "descriptor/passes.h"
#include "engine/engine.h"

namespace paradesc {

// Sizes of the triangles of a mesh, in units of the positions.
struct TriangleSizes {
  double longest_edge = 0;
  double rim_per_radius = 0; // how many the rim of a ball cuts, over its radius: mean over balls around the points
};
TriangleSizes measure_triangles(const Triangles &triangles, const HalfEdges &half_edges, int threads);

// Whether exact sums have what the pass asks for: the shape operator alone, at points of the mesh itself.
bool has_exact_sums(const Surface &surface, const Request &request, const Pass &pass);

// Whether they are right and fast at this radius: no triangle is large against the ball, and its rim does not cut too many.
bool suits_exact_sums(const TriangleSizes &sizes, double radius);

} // namespace paradesc
