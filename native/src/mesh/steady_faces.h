// Triangles → normals that are certain despite the rounding of positions, and the angles between them.
#pragma once

#include <span>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

// Heights below this share of the largest coordinate are meaningless: 64 roundings of a float.
constexpr double ROUNDING = 1.0 / (1 << 17);

// The face itself. For a needle (height below rounding), walks across longest edges to the first face that is not a needle.
int steady_face(const Triangles &triangles, const HalfEdges &half_edges, int face);
dvec3 steady_normal(const Triangles &triangles, const HalfEdges &half_edges, int face); // 0 if there is none
// The normals of all faces, rounded to floats, which is faster. A face that is folded over its neighbors gets the direction of
// the surface around it. normals: (triangle_count).
void round_steady_normals(const Triangles &triangles, const HalfEdges &half_edges, std::span<vec3> normals, int threads = 0);

// The signed angle between two unit normals around their common edge, which runs with the left face: in (-pi, pi], positive if
// the surface is convex.
double bend_between(dvec3 left, dvec3 right, dvec3 along);
// The angle by which the surface turns at a half-edge, in (-pi, pi]: positive where it is convex; 0 at boundaries.
double bend_at(const Triangles &triangles, const HalfEdges &half_edges, int half_edge);

// The corners of a face, read once.
struct Face {
  dvec3 a, b, c;

  Face(const Triangles &triangles, int face);
  dvec3 product() const { return glm::cross(b - a, c - a); }
  bool is_needle(dvec3 product) const; // its height is far below the rounding of positions, so its normal is meaningless
};

inline dvec3 along(const Triangles &triangles, int half_edge) {
  return dvec3(triangles.position(next_corner(half_edge))) - dvec3(triangles.position(half_edge));
}

} // namespace paradesc
