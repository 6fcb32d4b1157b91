// Triangles → their creases, with the normals that these are told by.
#pragma once

#include <vector>

#include "mesh/creases.h"
#include "mesh/steady_faces.h"

namespace paradesc::test {

inline std::vector<vec3> rounded_normals(const Triangles &triangles, const HalfEdges &half_edges, int threads = 0) {
  std::vector<vec3> normals(static_cast<size_t>(triangles.triangle_count));
  round_steady_normals(triangles, half_edges, normals, threads);
  return normals;
}

inline Creases creases_of(const Triangles &triangles, const HalfEdges &half_edges, int threads = 0) {
  return find_creases(triangles, half_edges, rounded_normals(triangles, half_edges, threads), threads);
}

} // namespace paradesc::test
