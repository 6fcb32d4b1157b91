// Positions → the size of a mesh, and of its edges.
#pragma once

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

struct Extent {
  Box box;
  double diagonal = 0.0; // of the box
};

Extent measure_extent(const Triangles &triangles, const HalfEdges &half_edges, int threads);
double mean_edge(const Triangles &triangles, const HalfEdges &half_edges, int threads);

} // namespace paradesc
