// Triangle list → manifold half-edges, as flat arrays. halfedge.cpp is the only file that includes OpenMesh.
//
// A point is a manifold vertex: it has one fan of faces. Vertices that an exporter split share a point; a vertex where several
// fans touch has several points. Edges are paired by vertex index first; the remaining half-edges are paired by place, so that
// closed components that merely touch stay apart. A surface is the same with and without copies of its faces.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/triangles.h"

namespace paradesc {

struct HalfEdges {
  int point_count = 0;
  std::vector<int32_t> corner_point;    // (3 * triangle_count) -1: triangle left out (degenerate, or a copy)
  std::vector<int32_t> twin;            // (3 * triangle_count) the other side's half-edge; -1: boundary or left out
  std::vector<int32_t> point_vertex;    // (point_count) an original vertex there
  std::vector<int32_t> point_half_edge; // (point_count) an outgoing half-edge; of a boundary point, the one with which turning
                                        // by twin[previous_corner(h)] reaches every face
  std::vector<int32_t> vertex_point;    // (vertex_count) the point that answers for the vertex; -1: loose. A vertex whose
                                        // faces were all left out gets the point at its place
  std::vector<uint8_t> point_boundary;  // (point_count) 1: on a boundary

  int degenerate_triangles = 0;
  int copied_triangles = 0; // left out because they lie at the places of others, see leave_out_copies
  int nonmanifold_edges = 0;
  int opposed_edges = 0; // nonmanifold edges along which all faces run the same way
  int nonmanifold_vertices = 0;
  int boundary_edges = 0;
  int welded_vertices = 0;
  int loose_vertices = 0;
  int components = 0;                  // connected
  std::vector<int32_t> triangle_piece; // (triangle_count) those of one component share a number; -1: left out
};

// Calls visit(corner) for each corner of a point, turning from its first one.
template <class Visit> void for_each_corner_around(const HalfEdges &half_edges, int32_t point, const Visit &visit) {
  const int32_t first = half_edges.point_half_edge[point];
  for (int32_t corner = first; corner >= 0;) {
    visit(corner);
    corner = half_edges.twin[previous_corner(corner)];
    if (corner == first) break;
  }
}

// threads as in pdesc_context_options.
HalfEdges build_half_edges(const Triangles &triangles, int threads = 0);

// Corners around one point that are reached from each other by turning across links (link[h]: the half-edge across, or -1; links
// are mutual). Fans of twins are points, fans of links within charts are wedges.
struct Fans {
  int count = 0;
  std::vector<int32_t> corner_fan; // (3 * triangle_count) numbered by first corner; -1: triangle left out
  std::vector<int32_t> first;      // (count) the corner from which turning by link[previous_corner(h)] reaches every other
};

// Connected components: triangles that are reached from each other across links.
struct Pieces {
  int count = 0;
  std::vector<int32_t> triangle_piece; // (triangle_count) numbered by first triangle; -1: left out
};

// left_out: (triangle_count) 1 where a triangle takes no part; its links are -1.
Fans trace_fans(const std::vector<int32_t> &link, const std::vector<uint8_t> &left_out);
Pieces trace_pieces(const std::vector<int32_t> &link, const std::vector<uint8_t> &left_out);

// The angle at a corner on the surface, in radians.
double surface_angle(const Triangles &triangles, int corner);

// The box around the vertices that have a point; if there are none, a box of no size at the origin.
struct Box {
  dvec3 low{0.0}, high{0.0};
  double diagonal() const { return length(high - low); }
};
Box bounding_box(const Triangles &triangles, const HalfEdges &half_edges, int threads = 0);

// The mean length of all edges; 0 if there are none.
double mean_edge(const Triangles &triangles, const HalfEdges &half_edges, int threads);

} // namespace paradesc
