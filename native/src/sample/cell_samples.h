// Cells + the area elements of a frame → the samples of each cell: one texel of every square of 1, 2, 4… texels.
//
// Which texels those are depends on the surface and the seed, not on the vertex: a vertex on a seam gets the same samples from
// each of its places, and the error of a field varies smoothly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sample/cells.h"

#include "shared.h"

namespace paradesc {

// What decides which texels are samples; lists are kept from frame to frame while it stays the same.
struct CellStrides {
  uint32_t seed = 0;
  std::vector<int32_t> coarse, fine; // (cells) texels between samples, powers of two; fine: near a vertex
  bool operator==(const CellStrides &) const = default;
};

struct CellSamples {
  CellStrides strides;
  std::vector<ivec2> list; // texel, x + 65536 y; bits of the area in (u, v) that it stands for, a float
  std::vector<ivec2>
      range; // (2, cells, 2) first and end in list: coarse, then fine; the black squares of a chessboard, the white
  ivec2 of(bool fine, int32_t cell, int half) const {
    return range[2 * (static_cast<size_t>(cell) + (fine ? strides.coarse.size() : 0)) + static_cast<size_t>(half)];
  }
};

// So few texels between samples that no square has more area than one of `samples` equal parts of a disk of that radius; a
// quarter of that between fine ones.
CellStrides choose_strides(const Cells &cells, std::span<const CellData> measured, int buffer_size, float radius, int samples,
                           uint32_t seed);

// (size * size) texels; threads as in pdesc_context_options.
CellSamples list_samples(const Cells &cells, CellStrides strides, int buffer_size, int threads);

} // namespace paradesc
