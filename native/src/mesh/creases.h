// Triangles → creases. These are the edges along which a surface has no tangent plane: edges marked sharp, and edges whose
// dihedral angle stands out from its surroundings. Normals are not averaged across creases, and curvature near them is that of
// the solid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

struct Creases {
  std::vector<int32_t> edges;     // the first half-edge of each crease, ascending
  std::vector<uint8_t> half_edge; // (3 * triangle_count) 1: on a crease; both sides alike. Empty if there are no creases

  bool contains(int32_t index) const { return !half_edge.empty() && half_edge[index] != 0; }
  bool operator==(const Creases &other) const { return edges == other.edges; }
};

// edges: as in Creases.
Creases creases_along(const HalfEdges &half_edges, std::vector<int32_t> edges);

// Finds the creases. They depend on positions: an edge that bends may become a crease. An edge is one if it is marked and both of
// its faces are smooth, or if one of these is true:
// - It bends by 20 degrees, and three times as much as any edge along it on either side, or eight times as much as any edge on
//   one side (the flat side of a bevel). Edges count up to a distance of three times the width of the narrower triangle.
// - It bends by 50 degrees, and 2.5 times as much as the other edges of its two triangles do along it (a box of one quad a side).
// Connected unmarked edges form a line. Within four mean edges around it, a line of a polyhedron bends eight times as much as all
// other edges. Any other line has at least 16 edges, and its bends are not taken back beside it, as those of stair steps, needles
// and folds are. Edges of noise bend as much as their neighbors, and so do edges of a coarse smooth surface. At an oblique corner
// of a solid, edges of one triangle hide each other. If they bend by 60 to 150 degrees the same way, they do not count beside
// each other if their whole line bends twice as much as all other edges around it. No line in noise does that. normals:
// (triangle_count) round_steady_normals.
Creases find_creases(const Triangles &triangles, const HalfEdges &half_edges, std::span<const vec3> normals, int threads = 0);

// Returns the marked creases only.
Creases marked_creases(const Triangles &triangles, const HalfEdges &half_edges);

// Returns the creases that count at a radius. Marked creases always count. A line of other creases counts if all other edges
// within CREASE_REACH radii around it turn the normals by at most 0.7 of what the creases do. A fold on a surface that itself
// bends as much is not the edge of a solid. Bends whose signs vary like noise cancel. normals: as for find_creases.
Creases creases_that_count(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases,
                           std::span<const vec3> normals, double radius, int threads = 0);

} // namespace paradesc
