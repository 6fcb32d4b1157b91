// The oracle: descriptors by exact quadrature over the connected part of the surface within r, in object space, in double.
// It shares positions and normals with the texture-space path and nothing else.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// What quadrature leaves behind at one point. w is area; d = q - p, rho = |d|, n the unit normal at p, n_i that at q.
struct ReferenceNeighborhood {
  double radius = 0;
  double area = 0;       // integral of w
  double rho = 0;        // of w rho
  double height = 0;     // of w n.d
  double bending = 0;    // of w |n - n_i|^2 / rho^2
  double k1 = 0, k2 = 0; // of the least-squares shape operator, k1 >= k2; NaN where it cannot be fitted
  bool boundary = false; // a mesh boundary lies within the ball
};

// One of these for each row of descriptors.def; each gives NaN where the value does not exist.
#define DESCRIPTOR(name, ...) double reference_##name(const ReferenceNeighborhood &neighborhood);
#include "descriptor/descriptors.def"
#undef DESCRIPTOR

struct ReferenceField {
  std::vector<std::vector<float>> values; // [descriptor asked for][point]
  std::vector<uint8_t> boundary;          // (point_count)
};

// descriptors: indices into the registry. progress(fraction) returns false to cancel: then Error(CANCELLED) is thrown.
ReferenceField compute_reference(const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals, double radius,
                                 std::span<const int> descriptors, int threads, const std::function<bool(double)> &progress);

} // namespace paradesc
