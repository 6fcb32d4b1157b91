// Charts → a private layout in which no two charts share texture space. The caller's UV map is not touched.
#pragma once

#include <optional>

#include "mesh/charts.h"
#include "mesh/triangles.h"

namespace paradesc {

// The charts, each moved and turned as a whole into the unit square, with a gutter between them; those that are strongly
// stretched are scaled back along that direction. Seams, wedges and borders stay what they are. A chart that overlaps itself
// still does: cut it first. None if half of the surface would not get texels at least least_gain times as dense, in the direction
// in which a chart has the fewest, as it has. threads as in pdesc_context_options.
std::optional<Charts> repack_charts(const Triangles &triangles, const Charts &charts, double least_gain = 0.0, int threads = 0);

} // namespace paradesc
