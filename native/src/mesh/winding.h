// Half-edges → which parts are wound with their outside inside.
#pragma once

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

// Closed parts of negative volume, but for those within the box of a larger closed part of positive volume: its hollows.
// box: bounding_box.
int count_inward_parts(const Triangles &triangles, const HalfEdges &half_edges, const Box &box, int threads = 0);

} // namespace paradesc
