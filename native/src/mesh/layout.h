// Charts → a private layout in which no two charts share texture space. The caller's UV map is not touched.
#pragma once

#include <optional>

#include "mesh/charts.h"
#include "mesh/triangles.h"

namespace paradesc {

// Moves and turns each chart as a whole into the unit square, with a gutter between charts; strongly stretched charts are scaled
// back along that direction. Seams, wedges and borders stay as they are. A chart that overlaps itself still does: cut it first.
// Returns nothing unless half of the surface gets texels at least least_gain times as dense as now, in the direction in which
// each chart has the fewest. threads as in pdesc_context_options.
std::optional<Charts> repack_charts(const Triangles &triangles, const Charts &charts, double least_gain = 0.0, int threads = 0);

} // namespace paradesc
