// Creases → the creases that count at a radius.
#pragma once

#include "mesh/creases.h"

namespace paradesc {

// Marked creases always count. A line of other creases counts if all other edges within CREASE_REACH radii around it turn the
// normals by at most 0.7 of what the creases do. A fold on a surface that itself bends as much is not the edge of a solid. Bends
// whose signs vary like noise cancel.
// normals: as for find_creases.
Creases creases_that_count(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases,
                           std::span<const vec3> normals, double radius, int threads = 0);

} // namespace paradesc
