// Cells + the spheres of a frame → what centers find their neighborhoods in: the cells near those that start in one cell.
//
// The cells that are connected to a cell over links are found once for all centers in it; neighborhoods.comp.glsl looks for each
// center's own neighborhood among them. Triangles without texels are samples by themselves.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "mesh/normals.h"
#include "sample/cell_samples.h"
#include "sample/cells.h"

#include "shared.h"

namespace paradesc {

// Triangles that no texel carries count all the same, by samples of their own.
struct TexellessSamples {
  std::vector<int32_t> begin; // (cells + 1)
  std::vector<TexellessSample> samples;
  std::vector<vec2> weights; // (samples) of the triangle's corners 1 and 2: where the sample lies
};

// displaced: the surface as maps displace it, else NULL. radius in buffer units.
TexellessSamples sample_texelless_triangles(const Cells &cells, const Triangles &triangles,
                                            const std::function<vec3(size_t corner)> &normal_of, const BakeSpace &bake_space,
                                            float radius, const DisplacedSurface *displaced = nullptr);

// The cells, with spheres and cones that enclose these samples as well.
std::vector<CellData> with_texelless_samples(std::span<const CellData> measured, const TexellessSamples &texelless);

// Where centers start from.
struct Starts {
  std::vector<ivec2> range;   // (centers) first and end in cell
  std::vector<ivec2> cell;    // and 0; the first one of a center is the one that it belongs to
  std::vector<int32_t> order; // centers, so that those of one cell follow each other
  std::vector<int32_t> begin; // (cells + 1) into order; the last centers start nowhere
};

// begin: (centers + 1) into the cells that each center starts from.
Starts list_starts(std::span<const int32_t> begin, std::span<const int32_t> start_cells, int cell_count);

// Makes these the starts of the same centers in their order, which is returned.
std::vector<int32_t> put_in_order(Starts &starts);

// The cells connected to each cell in which centers start, over cells that come near any ball of these centers.
struct NearCells {
  std::vector<ivec2> range; // (cells) first and end in cell
  std::vector<ivec4> cell;  // sorted; the one that centers start in; where its neighbors begin among those of all; CELL_ bits
  size_t neighbors = 0;     // of all
  std::vector<vec4> normal; // (cells) their mean normal
  size_t most = 0;          // of one cell
  bool any_fine = false;    // whether a cell has fine samples
};

// Where centers lie: some of these positions, which a space takes to buffer units.
struct CenterPositions {
  std::span<const vec3> all;
  std::span<const int32_t> index; // (centers) into all
  BakeSpace space;
};

// radius in buffer units; threads as in pdesc_context_options.
NearCells find_near_cells(const Cells &cells, const CellStrides &strides, std::span<const CellData> measured,
                          const Starts &starts, const CenterPositions &positions, float radius, int threads);

} // namespace paradesc
