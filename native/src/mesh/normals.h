// Positions → unit normals at corners and at points. "Normals decide" the error of everything else, see native/README.md.
//
// A fan is the part of a point's faces that no crease cuts off; corners of one fan share one normal.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "mesh/creases.h"
#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

// Found once per topology and its creases.
struct NormalRings {
  int fan_count = 0;
  std::shared_ptr<const std::vector<int32_t>> corner_fan; // (3 * triangle_count) -1 for triangles left out
  std::vector<int32_t> fan_point;                         // (fan_count)
  std::vector<int32_t> point_fan;                         // (point_count) -1 for points of several fans
  std::vector<int32_t> fan_begin;                         // (fan_count + 1) into fan_vertex
  std::vector<int32_t> fan_vertex;  // the fan's own vertex; those around it, in turning order: each face lies between two of them
  std::vector<int32_t> ring_begin;  // (fan_count + 1) into ring_vertex
  std::vector<int32_t> ring_vertex; // neighbors over rings of the mesh, nearest ring first, creases never crossed
  std::vector<int32_t> face_begin;  // (fan_count + 1) into face
  std::vector<int32_t> face;        // triangles of the rings used, the fan's own first
};

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

// threads as in pdesc_context_options.
NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, int threads = 0);
NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, int threads = 0); // marked creases alone

// kind as pdesc_normals. Throws Error(INVALID_OPERATION) for MESH where no corner normals were given.
Normals compute_normals(const Triangles &triangles, const HalfEdges &half_edges, const NormalRings &rings, int32_t kind,
                        int threads);

} // namespace paradesc
