// A surface → the centers of evaluation: the points of the mesh, or the texels of a map over its UV layout.
#pragma once

#include "descriptor/passes.h"
#include "engine/engine.h"
#include "sample/center_point.h"
#include "sample/texels.h"

namespace paradesc {

// Returns the first `count` points of the surface.
CenterPoints centers_at_points(const Surface &surface, const BakeSpace &space, int32_t count, int threads);

// Returns the texels of a map over the layout. A layout in which parts of the surface overlap is replaced first.
TexelMap lay_out_texels(const Surface &surface, int size, int threads);

// Returns the map's centers [first, last).
CenterPoints centers_at_texels(const Surface &surface, const BakeSpace &space, const TexelMap &texels, size_t first, size_t last,
                               int threads);

// Interpolates values at points linearly on triangles, at the map's centers [first, last).
MapValues map_at_texels(const Surface &surface, const TexelMap &texels, const MapValues &points, size_t first, size_t last,
                        int threads);

} // namespace paradesc
