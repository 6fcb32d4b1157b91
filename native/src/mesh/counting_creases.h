// Creases → those that count at a radius.
#pragma once

#include "mesh/creases.h"

namespace paradesc {

// Marked ones count. Lines of others do if, within CREASE_REACH radii around them, creases turn the normals at least
// CREASE_LEAST_SHARE times as much as all other edges there do: beside what bends by itself as much a fold is no edge of a solid.
// normals: as for find_creases.
Creases creases_that_count(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases,
                           std::span<const vec3> normals, double radius, int threads = 0);

} // namespace paradesc
