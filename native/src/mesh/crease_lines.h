// Edges → the lines that they form, and how the surface turns along them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

// How normals turn over the edges in a ball around a place of a line. Bends are weighed by a bowl that is 0 at the ball's rim.
struct Turning {
  double edges = 0;       // bends of the line's own and all other chosen edges, as absolute values
  double others = 0;      // those of all other edges
  double net = 0;         // norm of the tensor of all edges, in which bends back and forth cancel
  double others_net2 = 0; // squared norms of the other edges' tensors, octant by octant, less what random signs leave
};

struct EdgeLine {
  int edges = 0, ends = 0;      // ends within the surface
  double length = 0, reach = 0; // of its edges; of the balls around them
  int places = 0, agreed = 0;   // along it, and those of which the judge said yes

  bool is_agreed() const { return 2 * agreed >= places; }
};

struct EdgeLines {
  std::vector<int32_t> line_of; // (edges) into line
  std::vector<EdgeLine> line;
};

using JudgePlace = bool (*)(const EdgeLine &, const Turning &);

// Lines of edges that hang together at points, judged by what lies around places along them.
// edges: first half-edges, ascending. chosen: (3 * triangle_count) 1 on both sides of these edges. normals: (triangle_count)
// round_steady_normals. A ball reaches as far as least_reach, and edges_in_reach mean edges of its line.
EdgeLines judge_lines(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> edges,
                      std::span<const uint8_t> chosen, std::span<const vec3> normals, double least_reach, double edges_in_reach,
                      JudgePlace judge, int threads = 0);

} // namespace paradesc
