// Baked texels → cells, the connected pieces of charts within blocks of the buffer, and the links between them, over seams too.
//
// Cells are how a neighborhood is found: from the cells of the center's own wedges over links, as far as they meet
// the ball. That is the connected part of the surface in the ball, however the charts lie; no map from chart to chart is
// extrapolated, so neighboring seam edges leave neither gaps nor overlaps. Topology and buffer size decide cells and links;
// positions do not.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "mesh/triangles.h"
#include "sample/border_grid.h"

namespace paradesc {

// In an order in which cells that lie close together follow each other, on the surface and then in the buffer.
struct Cells {
  int count = 0;
  int block_size = 0;         // texels, a power of two
  std::vector<int32_t> label; // (size * size, 2) cell of each texel, or -1; part of the texel that its chart covers, of 65536
  std::vector<ivec4> box;     // (count) low texel, width and height of what holds its texels, within one block
  std::vector<int32_t> adjacency_begin; // (count + 1) into adjacency
  std::vector<ivec2> adjacency;         // neighboring cell, link
  std::vector<int32_t> link_begin;     // (links + 1) into link_texel
  std::vector<int32_t> link_texel;     // where the surface goes over from cell to cell
  std::vector<int32_t> boundary_begin; // (count + 1) into boundary
  std::vector<int32_t> boundary;       // half-edges on the mesh's boundary that a cell touches
  std::vector<int32_t> texelless_begin; // (count + 1) into texelless
  std::vector<int32_t> texelless;       // triangles that no texel carries, at the cell from which the surface leads to them
  std::vector<int32_t> triangle_cell;   // (triangle_count) that carries its middle, or leads there; -1: none
  std::vector<int32_t> wedge_cell; // (wedges)
};

// ids: (size * size, 2) as GeometryBuffer::read_ids. threads as in pdesc_context_options.
Cells build_cells(const std::vector<int32_t> &ids, const BorderGrid &grid, const Triangles &triangles,
                  const HalfEdges &half_edges, const Charts &charts, int block_size, int threads = 0);

// A position in a triangle of the layout, just inside it.
struct LayoutPosition {
  vec2 uv;
  int32_t triangle;
};

// The cell that carries each position, or the one from which the surface leads there; -1: none.
std::vector<int32_t> find_cells(const Cells &cells, const std::vector<int32_t> &ids, const BorderGrid &grid, const Charts &charts,
                                const std::vector<LayoutPosition> &positions, int threads);

} // namespace paradesc
