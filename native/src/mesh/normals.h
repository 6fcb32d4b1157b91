// Positions → unit normals at corners and at points. "Normals decide" the error of everything else, see native/README.md.
//
// A fan is the part of a point's faces that no sharp edge cuts off; corners of one fan share one normal.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

// Found once per topology.
struct NormalRings {
  int fan_count = 0;
  std::vector<int32_t> corner_fan; // (3 * triangle_count) -1 for triangles left out
  std::vector<int32_t> fan_point;  // (fan_count)
  std::vector<int32_t> ring_begin; // (fan_count + 1) into ring_point
  std::vector<int32_t> ring_point; // neighbors over rings of the mesh, nearest ring first, sharp edges never crossed
  std::vector<int32_t> face_begin; // (fan_count + 1) into face
  std::vector<int32_t> face;       // triangles of the rings used, the fan's own first
  std::vector<int32_t> own_faces;  // (fan_count) how many of those are the fan's own
};

struct Normals {
  std::vector<vec3> corner; // (3 * triangle_count) unit; zero for triangles left out
  std::vector<vec3> point;  // (point_count) unit: of the evaluation at that point, common to all its fans
};

// threads as in pdesc_context_options.
NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, int threads = 0);

// kind as pdesc_normals. Throws Error(INVALID_OPERATION) for MESH where no corner normals were given.
Normals compute_normals(const Triangles &triangles, const HalfEdges &half_edges, const NormalRings &rings, int32_t kind,
                        int threads);

} // namespace paradesc
