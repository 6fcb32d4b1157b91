// Creases → those that count at a radius.
#pragma once

#include "mesh/creases.h"

namespace paradesc {

// Marked creases always count. Lines of other creases count if, within CREASE_REACH radii around them, all other edges together
// turn the normals by at most 0.7 of what the creases do: a fold on a surface that bends as much by itself is not the edge of a
// solid. Bends whose signs vary like noise cancel.
// normals: as for find_creases.
Creases creases_that_count(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases,
                           std::span<const vec3> normals, double radius, int threads = 0);

} // namespace paradesc
