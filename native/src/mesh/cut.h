// Charts that overlap themselves in the UV map → pieces that do not.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

struct Cuts {
  bool overlapping = false;            // two triangles overlap in the UV map, of one chart or of two
  int cut_charts = 0;                  // charts that overlap themselves
  std::vector<int32_t> triangle_piece; // (triangle_count) numbered through all charts; -1: on no chart
};

// Exact up to a hair (2e-6 of the unit square). Pieces are connected over the chart's inner edges, and each grows as far as
// possible; a chart that does not overlap itself is one piece. build_charts makes charts of the pieces.
// threads as in pdesc_context_options.
Cuts cut_charts(const HalfEdges &half_edges, const Charts &charts, int threads = 0);

} // namespace paradesc
