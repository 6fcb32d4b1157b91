// Charts → the texels of a square map over the layout, as centers of evaluation (paper 4.1); and results there → results at
// points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "descriptor/results.h"
#include "mesh/charts.h"

namespace paradesc {

// A center of evaluation: the middle of a texel or, if that lies off the chart but the chart's border runs through the texel, the
// nearest position on that border.
struct TexelCenter {
  int32_t texel; // y * size + x
  int32_t triangle;
  int32_t chart;
  vec2 weights; // of the triangle's corners 1 and 2
  vec2 uv;
  bool on_border; // not at the texel's middle
};

struct TexelMap {
  int size = 0;
  std::vector<TexelCenter> centers; // by texel
  std::vector<int32_t> index;       // (size * size) into centers, or -1
  int overlapping = 0;              // texels whose middle lies within several triangles
};

TexelMap build_texel_map(const Charts &charts, int size);

// results: at all centers of the map → at points, by the primary wedge of each. Values are bilinear between texels of the wedge's
// own chart. Beside its border, where some texels are missing or have centers off their middles, a plane is fitted to the texels
// around. A point without a wedge, or without a nearby texel of its chart, has NaN.
CenterResults look_up(const TexelMap &map, const CenterResults &results, const Charts &charts, int threads = 0);

// An image of each descriptor, then of the coverage, then of the boundary, which is 1 where it cuts the neighborhood, else 0:
// (size * size, components), NaN where there is no surface.
std::vector<std::vector<float>> images_of(const TexelMap &map, const CenterResults &results, std::span<const int> descriptors);

} // namespace paradesc
