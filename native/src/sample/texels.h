// Charts → the places of a square map over the layout, one a texel, to evaluate at (paper 4.1); and from results there back to
// the places of vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/distortion.h"
#include "descriptor/results.h"
#include "mesh/charts.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"
#include "sample/cells.h"

#include "shared.h"

namespace paradesc {

// A place of the surface. Where the texel's center lies off the chart, but the chart's border runs through it: the nearest place
// of that border.
struct TexelPlace {
  int32_t texel; // y * size + x
  int32_t triangle;
  int32_t chart;
  vec2 weights; // of the triangle's corners 1 and 2
  vec2 uv;
  bool on_border; // not at the texel's center
};

struct TexelMap {
  int size = 0;
  std::vector<TexelPlace> places; // by texel
  std::vector<int32_t> place;     // (size * size) index into places, or -1
};

TexelMap build_texel_map(const Charts &charts, int size);

// Places [first, last) as centers, p and n in 32 bits. ellipses: (wedges), for the radius in buffer units times the enlargement;
// empty where samples do not march.
std::vector<CenterData> texel_centers(const TexelMap &map, const Triangles &triangles, const Charts &charts,
                                      const Normals &normals, const BakeSpace &bake_space, const std::vector<vec4> &ellipses,
                                      float ellipse_size, uint32_t seed, size_t first, size_t last);

// Where in the layout those centers are: for find_cells.
std::vector<LayoutPlace> texel_layout_places(const TexelMap &map, const Charts &charts, size_t first, size_t last);

// results: at all places of the map → at the places of points in the UV map; each point's primary one only, unless all_wedges.
// Bilinear between texels of the wedge's own chart; beside its border, where some are missing or not at their centers, by a plane
// fitted to those around. No row for a wedge with no texel of its chart near.
CenterResults look_up(const TexelMap &map, const CenterResults &results, const Charts &charts, bool all_wedges, int threads = 0);

// An image of each descriptor, then of the coverage: (size * size, components), NaN where there is no surface. A map without
// places has no results at all.
std::vector<std::vector<float>> images_of(const TexelMap &map, const CenterResults &results, std::span<const int> descriptors);

} // namespace paradesc
