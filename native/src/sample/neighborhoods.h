// Cells + positions of a frame → the neighborhood of each center: the samples of the surface connected to it within the ball.
//
// The cells that are connected to a cell over links are found once for all centers in it. If those within a center's ball form a
// single sheet, which faces the center's way and does not fold back, they are its neighborhood. Elsewhere, and at the mesh's
// boundary, each center searches by itself, over links that lie in its own ball.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "mesh/normals.h"
#include "sample/cell_samples.h"
#include "sample/cells.h"

#include "shared.h"

namespace paradesc {

// The samples of each center's neighborhood.
struct Neighborhoods {
  std::vector<NeighborhoodRanges> center; // (centers)
  std::vector<ivec2> range;               // first and end of samples, see NeighborhoodRanges
  std::vector<uint8_t> single_sheet; // (centers) the surface in the ball faces one way; others searched by themselves
  std::vector<int32_t> order;        // centers, so that those with common samples follow each other

  // center[i] becomes what was center[order_now[i]].
  void permute(const std::vector<int32_t> &order_now);
};

struct SearchCenter {
  vec3 position;                  // buffer units
  std::span<const int32_t> wedges; // to start from
  int32_t cell;                   // to start from as well, or -1
};

// Triangles that no texel carries count all the same, by samples of their own.
struct TexellessSamples {
  std::vector<int32_t> begin; // (cells + 1)
  std::vector<TexellessSample> samples;
  std::vector<vec2> weights;  // (samples) of the triangle's corners 1 and 2: where the sample lies
};

// displaced: the surface as maps displace it, else NULL. radius in buffer units.
TexellessSamples sample_texelless_triangles(const Cells &cells, const Triangles &triangles, const Normals &normals,
                                            const BakeSpace &bake_space, float radius,
                                            const DisplacedSurface *displaced = nullptr);

// The inputs of the search, of one frame.
struct SearchSpace {
  const Cells &cells;
  const CellSamples &samples;
  std::span<const CellData> measured;
  const TexellessSamples &texelless;
  const Triangles &triangles;
  const BakeSpace &bake_space;
  std::function<const std::vector<vec3> &()> link_points; // (cells.link_texel) in buffer units, where they are asked for
  bool halves;                                            // samples in two turns, black squares and white ones
};

// radius in buffer units. Throws Error(OUT_OF_MEMORY) where all neighborhoods together have more ranges than `max_ranges`, or
// than can be counted.
Neighborhoods find_neighborhoods(const SearchSpace &space, const std::vector<SearchCenter> &centers, float radius, int threads,
                                 size_t max_ranges = std::numeric_limits<int32_t>::max());

} // namespace paradesc
