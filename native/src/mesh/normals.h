// Positions → unit normals at corners and at points. Errors of normals dominate all other errors, see native/README.md.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "mesh/normal_rings.h"

namespace paradesc {

struct Normals {
  std::vector<vec3> group; // unit: of each fan, or of each corner where corners have normals of their own
  std::shared_ptr<const std::vector<int32_t>> corner_fan; // of the rings; none where corners have normals of their own
  std::vector<float> noise; // (fans) variance of the positions around the fit, along the normal; empty if nothing is fitted
  std::vector<vec3> point;  // (point_count) unit: the normal for evaluation at that point, common to all its fans
  // The unit normal of a corner; zero for triangles left out.
  vec3 corner(size_t corner) const {
    if (!corner_fan) return group[corner];
    const int32_t fan = (*corner_fan)[corner];
    return fan < 0 ? vec3(0.0f) : group[fan];
  }
  // The mean noise of a triangle's corners; NaN if it is not known.
  float noise_of(int32_t triangle) const;
};

// The normals of a surface at one moment, made on first use.
struct NormalsOnDemand {
  std::function<const Normals &()> make;
  std::array<uint64_t, 3> key{}; // differs whenever the normals of one mesh do

  const Normals &operator()() const { return make(); }
};

// kind as pdesc_normals; threads as in pdesc_context_options. Throws Error(INVALID_OPERATION) for MESH if no corner normals were
// given.
Normals compute_normals(const Triangles &triangles, const HalfEdges &half_edges, const NormalRings &rings, int32_t kind,
                        int threads);
// Computes normals without storing rings, which take more memory than the mesh. The bits are the same; the rings cost time again.
Normals compute_normals_once(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, int32_t kind,
                             int threads);

} // namespace paradesc
