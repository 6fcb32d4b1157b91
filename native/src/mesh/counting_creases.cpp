// Sums the bending in balls around creases, line by line.
#include "mesh/counting_creases.h"

#include <utility>

#include "kernel/limits.h"
#include "mesh/crease_lines.h"
#include "support/cancel.h"

namespace paradesc {

// Returns whether the other edges turn the normals less than the creases do, or turn them by noise alone. Edges that are as sharp
// are no noise: the creases are single steps among others, as on a surface of voxels.
static bool stands_out(const EdgeLine &, const TurningWithin &turning_within) {
  constexpr double most_others = 0.7, as_sharp = 0.85;
  const Turning turning = turning_within(1);
  if (turning.edges >= turning.others) return true;
  return turning.others_sharpness < as_sharp * turning.sharpness &&
         turning.others_net2 <= most_others * most_others * turning.edges * turning.edges;
}

Creases creases_that_count(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases,
                           std::span<const vec3> normals, double radius, int threads) {
  if (creases.edges.empty()) return {};
  const Creases marked = marked_creases(triangles, half_edges);
  if (creases == marked) return creases;
  const EdgeLines lines = judge_lines(triangles, half_edges, creases.edges, creases.half_edge, normals, CREASE_REACH * radius, 0,
                                      stands_out, threads);
  return creases_of_lines(half_edges, creases.edges, lines, marked);
}

} // namespace paradesc
