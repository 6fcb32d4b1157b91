// Half-edges → the number of parts that are wound inside out.
#pragma once

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

// Counts closed parts of negative volume, except hollows: those within the box of a larger closed part of positive volume.
// box: bounding_box.
int count_inward_parts(const Triangles &triangles, const HalfEdges &half_edges, const Box &box, int threads = 0);

} // namespace paradesc
