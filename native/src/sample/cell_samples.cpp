// Strides → lists of texels, with the area in (u, v) that each stands for.
#include "sample/cell_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "support/parallel.h"

namespace paradesc {

// A power of two, from 1 to the texels of a square of that side.
static int32_t texels_of(float doublings, int side) {
  return 1 << static_cast<int>(std::clamp(doublings, 0.0f, 2.0f * std::log2(static_cast<float>(side))));
}

CellStrides choose_strides(const Cells &cells, std::span<const CellData> measured, int buffer_size, float radius, int samples,
                           uint32_t seed, int threads) {
  constexpr float finer = 3.0f; // doublings
  constexpr float even = 0.9f;  // cosine between the normals of a leaf without detail
  const int side = cells.block_size / 2;
  CellStrides strides{seed, std::vector<int32_t>(measured.size() * CELL_LEAVES), {}};
  strides.fine = strides.coarse;
  const float size = static_cast<float>(buffer_size);
  const float share = static_cast<float>(pi) * radius * radius / static_cast<float>(samples) * size * size;
  parallel_blocks(static_cast<int>(measured.size()), threads, 2048, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      // At the mesh's own boundary no other chart makes up for what texels leave out.
      const bool at_boundary = cells.boundary_begin[i] < cells.boundary_begin[i + 1];
      const float wanted = at_boundary ? share / 4.0f : share;
      float doublings[CELL_LEAVES], least = 64.0f;
      int detailed = 0, all = 0;
      for (size_t k = 0; k < CELL_LEAVES; ++k) {
        const LeafData &leaf = measured[i].leaf[k];
        doublings[k] = least;
        if (leaf.sphere.w < 0.0f) continue;
        ++all;
        detailed += leaf.area.y < even;
        doublings[k] = std::log2(wanted / leaf.area.x);
        least = std::min(least, doublings[k]);
      }
      const int32_t together = texels_of(least, cells.block_size);
      const bool joined = together > side * side && all == CELL_LEAVES && (detailed == 0 || detailed == all);
      for (size_t k = 0; k < CELL_LEAVES; ++k) {
        const bool fine = joined ? detailed > 0 : measured[i].leaf[k].area.y < even;
        const int32_t coarse = joined ? together : texels_of(doublings[k], side);
        strides.coarse[CELL_LEAVES * i + k] = coarse;
        strides.fine[CELL_LEAVES * i + k] = fine ? texels_of(doublings[k] - finer, side) : coarse;
      }
    }
  });
  return strides;
}

// Which texel of a square is its sample: one of the four around its middle, by turns, so that their mean is the middle. Nearly
// even samples measure a disk two to three times as well as jittered ones.
static ivec2 offset_of(int x, int y, int stride, uint32_t seed) {
  if (stride == 1) return ivec2(0);
  const int flip_x = static_cast<int>(seed & 1), flip_y = static_cast<int>(seed >> 1 & 1);
  return ivec2(stride / 2 - 1) + ivec2((y & 1) ^ flip_x, (x & 1) ^ flip_y);
}

namespace {

// Texels from low to high, which is past the end.
struct Rectangle {
  ivec2 low, high;
};

// The samples of some cells, and where each half of each leaf's begins among them.
struct Part {
  std::vector<ivec2> list;
  std::vector<int32_t> begin;
};

class Lister {
public:
  Lister(const Cells &cells, const CellStrides &strides, int buffer_size)
      : cells_(cells), strides_(strides), size_(buffer_size) {}

  void add_cell(size_t cell, bool fine, Part &part) const {
    const int side = cells_.block_size / 2;
    const ivec4 box = cells_.box[cell];
    const ivec2 low(box), high = low + ivec2(box.z, box.w), corner = low / cells_.block_size * cells_.block_size;
    for (int leaf = 0; leaf < CELL_LEAVES; ++leaf) {
      const size_t i = cell * CELL_LEAVES + static_cast<size_t>(leaf);
      const int32_t texels = (fine ? strides_.fine : strides_.coarse)[i];
      const bool joined = texels > side * side;
      const ivec2 begin = corner + side * ivec2(leaf & 1, leaf >> 1);
      const Rectangle among = joined ? Rectangle{low, high} : Rectangle{glm::max(low, begin), glm::min(high, begin + side)};
      for (const int half : {0, 1}) {
        part.begin.push_back(static_cast<int32_t>(part.list.size()));
        if ((fine && texels == strides_.coarse[i]) || (joined && leaf > 0)) continue;
        add_half(cell, among, texels, half, part);
      }
    }
  }

private:
  // Adds the samples of one half, each for `texels` texels: the halves are the colors of a chessboard of squares, or, where
  // samples are on one color only, its columns in turn.
  void add_half(size_t cell, const Rectangle &among, int texels, int half, Part &part) const {
    const int doublings = std::countr_zero(static_cast<uint32_t>(texels)), stride = 1 << doublings / 2;
    const bool checkered = doublings % 2 != 0;
    const int color = static_cast<int>(strides_.seed >> 2 & 1);
    const float size = static_cast<float>(size_), area = static_cast<float>(texels) / (size * size);
    if (among.low.x >= among.high.x || among.low.y >= among.high.y) return;
    for (int y = among.low.y / stride; y <= (among.high.y - 1) / stride; ++y)
      for (int x = among.low.x / stride; x <= (among.high.x - 1) / stride; ++x) {
        if (((checkered ? x : x ^ y) & 1) != half || (checkered && ((x ^ y) & 1) != color)) continue;
        const ivec2 texel = ivec2(x, y) * stride + offset_of(x, y, stride, strides_.seed);
        if (texel.x >= size_ || texel.y >= size_) continue;
        const size_t at = 2 * (static_cast<size_t>(texel.y) * static_cast<size_t>(size_) + static_cast<size_t>(texel.x));
        if (cells_.label[at] != static_cast<int32_t>(cell) || cells_.label[at + 1] <= 0) continue;
        part.list.emplace_back(texel.x | texel.y << 16,
                               std::bit_cast<int32_t>(area * static_cast<float>(cells_.label[at + 1]) / 65536.0f));
      }
  }

  const Cells &cells_;
  const CellStrides &strides_;
  int size_;
};

} // namespace

CellSamples list_samples(const Cells &cells, CellStrides strides, int buffer_size, int threads) {
  constexpr int block = 256;
  CellSamples samples;
  const Lister lister(cells, strides, buffer_size);
  for (const bool fine : {false, true}) {
    std::vector<Part> parts(static_cast<size_t>((cells.count + block - 1) / block));
    parallel_blocks(cells.count, threads, block, [&](int begin, int end) {
      Part part; // of its own: neighboring vectors share cache lines
      for (auto cell = static_cast<size_t>(begin); cell < static_cast<size_t>(end); ++cell) lister.add_cell(cell, fine, part);
      parts[begin / block] = std::move(part);
    });
    std::vector<int32_t> &begin = fine ? samples.fine : samples.coarse;
    begin.reserve(static_cast<size_t>(cells.count) * CELL_LEAVES * 2 + 1);
    for (const Part &part : parts) {
      const auto offset = static_cast<int32_t>(samples.list.size());
      for (const int32_t first : part.begin) begin.push_back(first + offset);
      samples.list.insert(samples.list.end(), part.list.begin(), part.list.end());
    }
    begin.push_back(static_cast<int32_t>(samples.list.size()));
  }
  samples.strides = std::move(strides);
  return samples;
}

} // namespace paradesc
