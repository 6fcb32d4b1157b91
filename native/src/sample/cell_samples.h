// Cells + the area elements of a frame → the samples of each cell: one texel of every square of 1, 2, 4… texels, or of every
// other such square, as on a chessboard.
//
// Which texels those are depends on the surface and the seed, not on the vertex: all wedges of a point get the same samples, and
// the error of a field varies smoothly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sample/cells.h"

#include "shared.h"

namespace paradesc {

// Strides decide which texels are samples; lists are kept from frame to frame while the strides stay the same.
struct CellStrides {
  uint32_t seed = 0;
  // (cells, CELL_LEAVES) texels per sample, a power of two; fine: near a center. A stride larger than a leaf means that the
  // samples belong to the whole cell; then all leaves of the cell have it.
  std::vector<int32_t> coarse, fine;
  bool operator==(const CellStrides &) const = default;
};

struct CellSamples {
  CellStrides strides;
  std::vector<ivec2> list; // texel, x + 65536 y; bits of the area in (u, v) that it stands for, a float
  // (cells * CELL_LEAVES * 2 + 1) into list, where a leaf's begin: one half of them, the other. Fine ones that are as many as
  // coarse ones are not listed once more.
  std::vector<int32_t> coarse, fine;

  ivec2 of_cell(bool is_fine, int32_t cell) const { return between(is_fine, at(cell, 0), 2 * CELL_LEAVES); }
  ivec2 of_leaf(bool is_fine, int32_t cell, int leaf) const { return between(is_fine, at(cell, leaf), 2); }
  ivec2 of_half(bool is_fine, int32_t cell, int leaf, int half) const {
    return between(is_fine, at(cell, leaf) + static_cast<size_t>(half), 1);
  }

private:
  static size_t at(int32_t cell, int leaf) { return (static_cast<size_t>(cell) * CELL_LEAVES + static_cast<size_t>(leaf)) * 2; }
  ivec2 between(bool is_fine, size_t first, size_t count) const {
    const std::vector<int32_t> &begin = is_fine ? fine : coarse;
    return {begin[first], begin[first + count]};
  }
};

// No sample stands for more area than 1 / samples of a disk of that radius; where the surface bends, no fine one for more than an
// eighth of that.
CellStrides choose_strides(const Cells &cells, std::span<const CellData> measured, int buffer_size, float radius, int samples,
                           uint32_t seed, int threads);

// (size * size) texels; threads as in pdesc_context_options.
CellSamples list_samples(const Cells &cells, CellStrides strides, int buffer_size, int threads);

} // namespace paradesc
