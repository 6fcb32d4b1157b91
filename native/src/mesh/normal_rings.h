// Fans and the rings around them, from whose positions normals are fitted.
//
// A fan is the part of a point's faces that no crease cuts off; corners of one fan share one normal.
#pragma once

#include <cstdint>
#include <functional>
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
  std::vector<int32_t> point_fan;                         // (point_count) below 0 for points of several fans, or none
  std::vector<int64_t> fan_begin;                         // (fan_count + 1) into fan_vertex
  std::vector<int32_t> fan_vertex;  // the fan's own vertex, then its neighbors in turning order: each face lies between two
  std::vector<int64_t> ring_begin;  // (fan_count + 1) into ring_vertex
  std::vector<int32_t> ring_vertex; // neighbors over rings of the mesh, nearest ring first, creases never crossed
  std::vector<int64_t> face_begin;  // (fan_count + 1) into face
  std::vector<int32_t> face;        // triangles of the rings used, the fan's own first
};

// The corners of each fan in turning order.
struct FanCorners {
  std::vector<int32_t> begin;
  std::vector<int32_t> corner;
};

// The rings of some fans that follow each other.
struct RingRun {
  int first_fan = 0;
  std::vector<int32_t> ring_size, face_size, vertices, faces;
};

// Appends the begins of lists of these sizes, following the lists that end at begins.back(). The begins are 64-bit: a mesh has
// far more ring neighbors than corners.
void append_begins(const std::vector<int32_t> &sizes, std::vector<int64_t> &begins);

// Finds the fans, which end at creases, without their rings.
FanCorners find_fans(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, NormalRings &rings);

// use(run) for all fans, run by run in any order, from all threads.
void walk_rings(const HalfEdges &half_edges, const NormalRings &rings, const FanCorners &fans, int threads,
                const std::function<void(RingRun)> &use);

// threads as in pdesc_context_options.
NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, const Creases &creases, int threads = 0);
NormalRings build_normal_rings(const Triangles &triangles, const HalfEdges &half_edges, int threads = 0); // marked creases alone

} // namespace paradesc
