// Charts → places of their own: a private layout in which no two charts share texture space. The caller's UV map is not touched.
#pragma once

#include "mesh/charts.h"
#include "mesh/triangles.h"

namespace paradesc {

// Moves and turns every chart as a whole into the unit square, with a gutter between them, and scales all alike: where the UV map
// gives more texels to a face than to a foot, so does this. Seams, sites and borders stay what they are. A chart that overlaps
// itself still does.
void repack_charts(Triangles &triangles, Charts &charts);

} // namespace paradesc
