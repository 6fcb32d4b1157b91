// Seam edges → the affine map M_e of each: t' = M_e t carries a (u, v) of one chart across the edge into the twin's chart.
//
// To first order the map across one seam edge is unique: unfold the far triangle into the near one's plane; the edge's two end
// points and isometry across the edge give M_e. This map replaces the paper's eq. (2) and (3), whose scale is inverted and which
// ignore theta_e.
#pragma once

#include <vector>

#include "mesh/charts.h"
#include "mesh/triangles.h"

namespace paradesc {

// Two vec4 per border: the linear part's columns; the image of the first end, the twin (or -1 - kind), the twin's chart.
std::vector<vec4> seam_links(const Triangles &triangles, const Charts &charts);

} // namespace paradesc
