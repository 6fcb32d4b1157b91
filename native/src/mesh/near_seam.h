// Seam edges → which points lie within a radius of one, along edges of the mesh.
#pragma once

#include "mesh/charts.h"

namespace paradesc {

// (vertex_count) 1 if an edge path of at most `radius` leads to an end of a seam.
std::vector<uint8_t> vertices_near_seams(const Triangles &triangles, const HalfEdges &half_edges, const Charts &charts,
                                         double radius);

} // namespace paradesc
