// Strides → lists of texels, with the area in (u, v) that each stands for.
#include "sample/cell_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "support/parallel.h"

namespace paradesc {

CellStrides choose_strides(const Cells &cells, std::span<const CellData> measured, int buffer_size, float radius, int samples,
                           uint32_t seed) {
  CellStrides strides{seed, {}, {}};
  const float share = static_cast<float>(pi) * radius * radius / static_cast<float>(samples);
  const float size = static_cast<float>(buffer_size);
  for (const CellData &cell : measured) {
    const float texel_area = std::max(cell.area.x, 1e-30f) / (size * size);
    const float doublings = 0.5f * std::log2(share / texel_area);
    auto stride = [&](float steps) { return std::min(1 << static_cast<int>(std::clamp(steps, 0.0f, 16.0f)), cells.block_size); };
    strides.coarse.push_back(stride(doublings));
    strides.fine.push_back(stride(doublings - 2.0f));
  }
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

// The samples of some cells, and where each half of each cell's begins and ends among them.
struct Part {
  std::vector<ivec2> list, range;
};

} // namespace

// Those in squares of one color.
static void add_half(const Cells &cells, size_t cell, int stride, uint32_t seed, int buffer_size, int half, Part &part) {
  const ivec4 box = cells.box[cell];
  const float size = static_cast<float>(buffer_size), area = static_cast<float>(stride * stride) / (size * size);
  const auto first = static_cast<int32_t>(part.list.size());
  for (int y = box.y / stride; y <= (box.y + box.w - 1) / stride; ++y)
    for (int x = box.x / stride; x <= (box.x + box.z - 1) / stride; ++x) {
      if (((x ^ y) & 1) != half) continue;
      const ivec2 texel = ivec2(x, y) * stride + offset_of(x, y, stride, seed);
      if (texel.x >= buffer_size || texel.y >= buffer_size) continue;
      const size_t at = 2 * (static_cast<size_t>(texel.y) * static_cast<size_t>(buffer_size) + static_cast<size_t>(texel.x));
      if (cells.label[at] != static_cast<int32_t>(cell) || cells.label[at + 1] <= 0) continue;
      part.list.emplace_back(texel.x | texel.y << 16,
                             std::bit_cast<int32_t>(area * static_cast<float>(cells.label[at + 1]) / 65536.0f));
    }
  part.range.emplace_back(first, static_cast<int32_t>(part.list.size()));
}

CellSamples list_samples(const Cells &cells, CellStrides strides, int buffer_size, int threads) {
  constexpr int block = 256;
  CellSamples samples;
  samples.range.reserve(4 * strides.coarse.size());
  for (const bool fine : {false, true}) {
    const std::vector<int32_t> &level = fine ? strides.fine : strides.coarse;
    std::vector<Part> parts(static_cast<size_t>((cells.count + block - 1) / block));
    parallel_blocks(cells.count, threads, block, [&](int begin, int end) {
      Part &part = parts[static_cast<size_t>(begin / block)];
      for (auto cell = static_cast<size_t>(begin); cell < static_cast<size_t>(end); ++cell)
        for (const int half : {0, 1}) {
          if (fine && level[cell] == strides.coarse[cell])
            part.range.emplace_back(-1, -1);
          else
            add_half(cells, cell, level[cell], strides.seed, buffer_size, half, part);
        }
    });
    for (const Part &part : parts) {
      const auto offset = static_cast<int32_t>(samples.list.size());
      for (const ivec2 range : part.range) // the same texels are listed once
        samples.range.push_back(range.x < 0 ? samples.range[samples.range.size() - 2 * strides.coarse.size()] : range + offset);
      samples.list.insert(samples.list.end(), part.list.begin(), part.list.end());
    }
  }
  samples.strides = std::move(strides);
  return samples;
}

} // namespace paradesc
