// Charts → places of their own: a private layout in which no two charts share texture space. The caller's UV map is not touched.
#pragma once

#include "mesh/charts.h"
#include "mesh/triangles.h"

namespace paradesc {

// Moves, turns and scales every chart as a whole, at even texel density, into the unit square with a gutter between them. Seams, sites
// and borders stay what they are. A chart that overlaps itself still does.
void repack_charts(Triangles &triangles, Charts &charts);

} // namespace paradesc
