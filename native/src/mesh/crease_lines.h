// Edges → the lines that they form, and the turning of the surface along them.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

// The turning of normals across the edges in a ball around a place of a line. Bends are weighted by a bowl that is 0 at the
// ball's rim.
struct Turning {
  double edges = 0;            // absolute bends of the line's own and all other chosen edges
  double others = 0;           // absolute bends of all other edges
  double sharpness = 0;        // mean chord of the bends of the first, weighted by these; 0 without any
  double others_sharpness = 0; // the same of the others
  double net = 0;              // norm of the tensor of all edges, in which bends back and forth cancel
  double others_net2 = 0;      // squared norms of the other edges' tensors by octant, less those expected of random signs

  double purity() const { return edges / others; }
};

struct EdgeLine {
  int edges = 0, ends = 0;      // ends that are not on the boundary
  double length = 0, reach = 0; // of its edges; of the balls around its places
  int places = 0, agreed = 0;   // places along it, and those that the judge accepted

  bool is_agreed() const { return 2 * agreed >= places; }
};

struct EdgeLines {
  std::vector<int32_t> line_of; // (edges) into line
  std::vector<EdgeLine> line;
};

// Returns the turning in a ball around a place whose radius is this part of the line's reach.
using TurningWithin = std::function<Turning(double)>;
using JudgePlace = bool (*)(const EdgeLine &, const TurningWithin &);

// Joins edges that share points into lines, and judges each line by the surroundings of places along it.
// edges: first half-edges, ascending. chosen: (3 * triangle_count) 1 on both sides of these edges. normals: (triangle_count)
// round_steady_normals. The radius of a line's balls is the larger of least_reach and edges_in_reach mean edges of the line.
EdgeLines judge_lines(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> edges,
                      std::span<const uint8_t> chosen, std::span<const vec3> normals, double least_reach, double edges_in_reach,
                      JudgePlace judge, int threads = 0);

} // namespace paradesc
