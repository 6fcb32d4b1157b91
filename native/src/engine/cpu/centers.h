// Where something is evaluated on a surface → centers: the points of the mesh, or texels of a map over its layout. The layout
// says which places of the surface the texels are, and nothing else is taken from it.
#pragma once

#include <vector>

#include "descriptor/passes.h"
#include "engine/cpu/groups.h"
#include "engine/engine.h"
#include "sample/texels.h"

namespace paradesc {

// The first points of the surface, that many.
TreeCenters centers_at_points(const Surface &surface, const BakeSpace &space, int32_t count, int threads);

// The texels of a map over the layout, which is made anew first where parts of the surface share texture space.
TexelMap lay_out_texels(const Surface &surface, int size, int threads);

// The map's centers [first, last).
TreeCenters centers_at_texels(const Surface &surface, const BakeSpace &space, const TexelMap &texels, size_t first, size_t last,
                              int threads);

// Values at points → at those centers, linear on triangles.
MapValues map_at_texels(const Surface &surface, const TexelMap &texels, const MapValues &points, size_t first, size_t last,
                        int threads);

} // namespace paradesc
