// Triangles → creases, the edges along which a surface has no tangent plane: those marked sharp, and those whose dihedral angle
// stands out from its surroundings. Normals do not reach over them, and curvature beside them is that of the solid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/crease_lines.h"
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
// Unmarked edges that hang together are a line. Within four of its edges around it, a line of a polyhedron bends eight times as
// much as all other edges. Any other line has 16 edges at least, and what it bends is not taken back beside it, as a step of a
// staircase, a needle and a fold are. Edges of noise are as bent as their neighbors, and those of a coarse smooth surface are,
// too. At a corner of a solid that is no right one, edges of one triangle hide each other. Such ones, of 60 to 150 degrees the
// same way, do not count beside each other where all of their line bends twice as much as all other edges around it, which no
// line in noise does. normals: (triangle_count) round_steady_normals.
Creases find_creases(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals, int threads = 0);

// Has the edges whose lines are agreed, and the kept ones. lines: of the edges, which ascend.
Creases creases_of_lines(const HalfEdges &half_edges, const std::vector<int32_t> &edges, const EdgeLines &lines,
                         const Creases &kept);

// The marked ones alone.
Creases marked_creases(const Triangles &triangles, const HalfEdges &half_edges);

} // namespace paradesc
