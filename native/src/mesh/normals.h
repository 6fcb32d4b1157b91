// Positions → unit normals at corners and at points. "Normals decide" the error of everything else, see native/README.md.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "mesh/normal_rings.h"

namespace paradesc {

struct Normals {
  std::vector<vec3> group; // unit: of each fan, or of each corner where corners have normals of their own
  std::shared_ptr<const std::vector<int32_t>> corner_fan; // of the rings; none where corners have normals of their own
  std::vector<vec3> point; // (point_count) unit: of the evaluation at that point, common to all its fans
  // Of one mesh: differ whenever normals do, and whenever corner_fan does. Whoever keeps normals sets them.
  uint64_t version = 0, fans_version = 0;
  // Unit; zero for triangles left out.
  vec3 corner(size_t corner) const {
    if (!corner_fan) return group[corner];
    const int32_t fan = (*corner_fan)[corner];
    return fan < 0 ? vec3(0.0f) : group[fan];
  }
};

// kind as pdesc_normals; threads as in pdesc_context_options. Throws Error(INVALID_OPERATION) for MESH where no corner normals
// were given.
Normals compute_normals(const Triangles &triangles, const HalfEdges &half_edges, const NormalRings &rings, int32_t kind,
                        int threads);
// Without rings, which take more memory than the mesh: the same bits, and the time of making the rings.
Normals compute_normals_once(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, int32_t kind,
                             int threads);

} // namespace paradesc
