// Triangles → creases, the edges along which a surface has no tangent plane: those marked sharp, and those whose dihedral angle
// stands out from its surroundings. Normals do not reach over them, and curvature beside them is that of the solid.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

struct Creases {
  std::vector<uint8_t> half_edge; // (3 * triangle_count) 1: on a crease; both sides alike
  int32_t edges = 0;

  bool operator==(const Creases &) const = default;
};

// Depends on positions: an edge that bends may become a crease. It is one if it is marked and both of its faces are smooth, or if
// - it bends by 20 degrees, and three times as much as any edge that runs along with it beside it on either side, or eight times
//   as much as any on one of its sides (the flat side of a bevel); beside is within three times the width of the narrower
//   triangle;
// - it bends by 50 degrees, and 2.5 times as much as the other edges of its two triangles do along it (a box of one quad a side).
// Unmarked edges that hang together count only if they end nowhere within the surface, or are 16 at least: a fold of an organic
// surface comes and goes. Edges of noise are as bent as their neighbors, and those of a flat-shaded smooth surface are, too.
Creases find_creases(const Triangles &triangles, const HalfEdges &half_edges, int threads = 0);

// (point_count) creases that hang together share a number, that of one of their points.
std::vector<int32_t> line_of_points(const HalfEdges &half_edges, const Creases &creases);

int32_t count_edges(const Creases &creases);

// The marked ones alone.
Creases marked_creases(const Triangles &triangles, const HalfEdges &half_edges);

// Of the largest coordinate: below that, heights say nothing. 64 roundings of a float.
constexpr double ROUNDING = 1.0 / (1 << 17);

// The face itself; of a needle, lower than what rounds positions, the first face behind longest edges that is none.
int steady_face(const Triangles &triangles, const HalfEdges &half_edges, int face);
dvec3 steady_normal(const Triangles &triangles, const HalfEdges &half_edges, int face); // 0 if there is none
vec3 rounded_steady_normal(const Triangles &triangles, const HalfEdges &half_edges, int face); // to floats; faster

// By how much unit normals turn around the edge between them, which runs with the left face: in (-pi, pi], positive where the
// surface is convex.
double bend_between(dvec3 left, dvec3 right, dvec3 along);
// The angle by which the surface turns at a half-edge, in (-pi, pi]: positive where it is convex; 0 at boundaries.
double bend_at(const Triangles &triangles, const HalfEdges &half_edges, int half_edge);

} // namespace paradesc
