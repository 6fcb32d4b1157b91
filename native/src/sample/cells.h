// Baked texels → cells, the connected pieces of charts within blocks of the buffer, and the links between them, also across
// seams.
//
// Cells serve to find a neighborhood: the search starts in the cells of the center's own wedges and follows links as long as
// cells meet the ball. That gives the connected part of the surface in the ball, wherever the charts lie. No map from chart to
// chart is extrapolated, so neighboring seam edges leave neither gaps nor overlaps. Cells and links depend on topology and buffer
// size, but not on positions.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "mesh/triangles.h"
#include "sample/border_grid.h"

namespace paradesc {

// Cells are ordered so that cells close to each other on the surface, and then in the buffer, follow each other.
struct Cells {
  int count = 0;
  int block_size = 0;         // texels, a power of two
  std::vector<int32_t> label; // (size * size, 2) cell of each texel, or -1; share of the texel covered by its chart, of 65536
  std::vector<ivec4> box;     // (count) low texel, width and height of the cell's bounding box, within one block
  std::vector<int32_t> adjacency_begin; // (count + 1) into adjacency
  std::vector<ivec2> adjacency;         // neighboring cell, link
  std::vector<int32_t> link_begin;      // (links + 1) into link_texel
  std::vector<int32_t> link_texel;      // texels at which the surface crosses from cell to cell
  std::vector<int32_t> boundary_begin;  // (count + 1) into boundary
  std::vector<int32_t> boundary;        // half-edges on the mesh's boundary that a cell touches
  std::vector<int32_t> texelless_begin; // (count + 1) into texelless
  std::vector<int32_t> texelless;       // triangles without texels, at the cell from which the surface leads to them
  std::vector<int32_t> triangle_cell;   // (triangle_count) carries the centroid, or leads there; -1: none
  std::vector<int32_t> wedge_cell;      // (wedges)
};

// ids: (size * size, 2) as GeometryBuffer::read_ids. threads as in pdesc_context_options.
Cells build_cells(const std::vector<int32_t> &ids, const BorderGrid &grid, const Triangles &triangles,
                  const HalfEdges &half_edges, const Charts &charts, int block_size, int threads = 0);

// A position slightly inside a triangle of the layout.
struct LayoutPosition {
  vec2 uv;
  int32_t triangle;
};

// The cell that carries each position, or from which the surface leads there; -1: none.
std::vector<int32_t> find_cells(const Cells &cells, const std::vector<int32_t> &ids, const BorderGrid &grid, const Charts &charts,
                                const std::vector<LayoutPosition> &positions, int threads);

} // namespace paradesc
