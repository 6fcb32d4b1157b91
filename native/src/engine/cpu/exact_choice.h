// Chooses whether a pass sums over all triangles exactly (engine/cpu/exact_pass) or over samples.
#pragma once

#include "descriptor/passes.h"
#include "engine/engine.h"

namespace paradesc {

// Sizes of a mesh's triangles, in units of the positions.
struct TriangleSizes {
  double longest_edge = 0;
  double rim_per_radius = 0; // triangles that a ball's rim cuts, over its radius: mean over balls around the points
};
TriangleSizes measure_triangles(const Triangles &triangles, const HalfEdges &half_edges, int threads);

// Returns whether exact sums support the pass: it needs the shape operator only, at points of the mesh itself.
bool has_exact_sums(const Surface &surface, const Request &request, const Pass &pass);

// Returns whether they are accurate and fast at this radius: no triangle is large against the ball, and its rim cuts few enough.
bool suits_exact_sums(const TriangleSizes &sizes, double radius);

} // namespace paradesc
