// Ambiguous centers, whose samples do not look like one sheet of surface → those that have to be computed again, on exactly the
// triangles that are connected to them within the ball.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/patches.h"
#include "mesh/triangles.h"
#include "sample/connected_triangles.h"

namespace paradesc {

struct AmbiguousCenters {
  std::vector<int32_t> centers, points;
  std::vector<double> areas; // that their samples found, in units of the positions

  void push_back(int32_t center, int32_t point, double area);
  AmbiguousCenters part(size_t first, size_t last) const;
  // Keeps those for which keep(i) is true.
  void filter(const std::function<bool(size_t)> &keep);
};

// The surface on which centers are looked at again.
struct RecheckSpace {
  const Triangles &triangles; // displaced if maps displace the surface
  const HalfEdges &half_edges;
  double radius; // in units of the positions
  int samples;   // that a neighborhood was computed from: few of them say less about its area
  int threads;
  std::function<const Patches &()> patches; // of half_edges; made when first asked for
};

struct Recheck {
  std::function<void(double done)> before_batch; // part of the whole; may throw to cancel
  // Computes these centers again: center i on the triangles [begin[i], begin[i + 1]).
  std::function<void(std::span<const int32_t> centers, const ConnectedTriangles &triangles)> compute;
};

// Centers are handed on in batches, so that a computation can be cancelled between them and lists of triangles stay short.
void recheck(AmbiguousCenters centers, const RecheckSpace &space, const Recheck &again);

} // namespace paradesc
