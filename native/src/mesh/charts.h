// Half-edges + corner UVs → charts, the wedges of each point, and the border half-edges with their twins.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

enum class BorderKind : int32_t {
  seam = 0,     // the surface continues at the twin
  boundary = 1, // the surface ends
  unlinked = 2  // the surface continues, but on a triangle without UV area: nothing can be carried across
};

struct Border {
  int32_t half_edge; // 3 * triangle + corner
  int32_t twin;      // index into Charts::borders, or -1
  int32_t chart;
  BorderKind kind;
};

// All corners of one point on one chart that have the same (u, v) (Hoppe's term). A point on a seam has several wedges, every
// other point has one.
struct Wedge {
  int32_t point;
  int32_t chart;
  vec2 uv;
  vec2 inside;  // (u, v) of the centroid of the incident triangle that is widest there: a direction into the chart
  double angle; // of the wedge in the UV map as given, in radians
};

struct Charts {
  int chart_count = 0;
  SharedArray<vec2> corner_uv;           // (3 * triangle_count) where the corners lie in the layout; empty: no UV map
  std::vector<int32_t> triangle_chart;   // (triangle_count) -1: degenerate or without UV area
  std::vector<int32_t> corner_wedge;     // (3 * triangle_count) -1 where triangle_chart is -1
  std::vector<int32_t> half_edge_border; // (3 * triangle_count) index into borders, or -1
  std::vector<Wedge> wedges;
  std::vector<int32_t> point_wedge; // (point_count) the primary wedge, of the largest angle: it stays while the surface moves.
                                    // -1: the point has no wedge
  std::vector<Border> borders;

  int zero_uv_area_triangles = 0;
  int flipped_triangles = 0;
  int seam_edges = 0;
  int self_seam_edges = 0;
  int unlinked_edges = 0;
};

// triangle_piece: charts also end where two triangles have different numbers; empty: nowhere else. threads as in
// pdesc_context_options.
Charts build_charts(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> triangle_piece = {},
                    int threads = 0);

// The corners at the ends of a border, ordered so that its chart lies on the left of the way from the first to the second.
std::pair<int, int> border_ends(const Charts &charts, const Border &border);

} // namespace paradesc
