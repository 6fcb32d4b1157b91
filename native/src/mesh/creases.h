// Triangles → creases, the edges along which a surface has no tangent plane: those marked sharp, and those whose dihedral angle
// stands out from its surroundings. Normals do not reach over them, and curvature beside them is that of the solid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

struct Creases {
  std::vector<int32_t> edges;     // of each crease, its first half-edge; ascending
  std::vector<uint8_t> half_edge; // (3 * triangle_count) 1: on a crease; both sides alike. Empty where there are none

  bool contains(int32_t index) const { return !half_edge.empty() && half_edge[index] != 0; }
  bool operator==(const Creases &other) const { return edges == other.edges; }
};

// edges: as in Creases.
Creases creases_along(const HalfEdges &half_edges, std::vector<int32_t> edges);

// Depends on positions: an edge that bends may become a crease. It is one if it is marked and both of its faces are smooth, or if
// - it bends by 20 degrees, and three times as much as any edge that runs along with it beside it on either side, or eight times
//   as much as any on one of its sides (the flat side of a bevel); beside is within three times the width of the narrower
//   triangle;
// - it bends by 50 degrees, and 2.5 times as much as the other edges of its two triangles do along it (a box of one quad a side).
// Unmarked edges that hang together count only if they end nowhere within the surface, or are 16 at least: a fold of an organic
// surface comes and goes. Edges of noise are as bent as their neighbors, and those of a flat-shaded smooth surface are, too.
// normals: (triangle_count) round_steady_normals.
Creases find_creases(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals, int threads = 0);

// (edges) those that hang together share a number, that of one of their points.
std::vector<int32_t> lines_of(const HalfEdges &half_edges, const std::vector<int32_t> &edges);

// The marked ones alone.
Creases marked_creases(const Triangles &triangles, const HalfEdges &half_edges);

} // namespace paradesc
