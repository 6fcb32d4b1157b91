// Fills ring by ring: a step reads only texels defined before it and writes only undefined ones, so rows can go in any order.
#include "gather/gutter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "support/parallel.h"

namespace paradesc {
namespace {

constexpr int rows_at_once = 16;

// Flags of the defined texels, with a border of undefined texels around the image.
class Defined {
public:
  explicit Defined(ImageShape shape) : stride_(shape.width + 2), flags_(stride_ * (shape.height + 2)) {}
  // Rows go from -1 to height, columns from -1 to width.
  uint8_t *row(int y) { return flags_.data() + (y + 1) * stride_ + 1; }
  const uint8_t *row(int y) const { return flags_.data() + (y + 1) * stride_ + 1; }

private:
  size_t stride_;
  std::vector<uint8_t> flags_;
};

bool is_defined(const float *texel, int components) {
  return std::all_of(texel, texel + components, [](float x) { return std::isfinite(x); });
}

struct Image {
  float *values;
  ImageShape shape;
  float *texel(int x, int y) const { return values + (y * shape.width + x) * shape.components; }
};

// Sets ring to 1 for the undefined texels of a row that have a defined neighbor.
void find_ring(const Defined &defined, int y, int width, std::vector<uint8_t> &beside, std::vector<uint8_t> &ring) {
  const uint8_t *below = defined.row(y - 1) - 1, *here = defined.row(y) - 1, *above = defined.row(y + 1) - 1;
  for (int x = 0; x < width + 2; ++x) beside[x] = below[x] | here[x] | above[x];
  for (int x = 0; x < width; ++x) ring[x] = static_cast<uint8_t>((beside[x] | beside[x + 1] | beside[x + 2]) & (here[x + 1] ^ 1));
}

void fill_texel(const Image &image, const Defined &defined, int x, int y) {
  float count = 0.0f;
  float total[4] = {};
  for (int row = y - 1; row <= y + 1; ++row)
    for (int column = x - 1; column <= x + 1; ++column)
      if (defined.row(row)[column]) {
        const float *beside = image.texel(column, row);
        for (int i = 0; i < image.shape.components; ++i) total[i] += beside[i];
        count += 1.0f;
      }
  float *texel = image.texel(x, y);
  for (int i = 0; i < image.shape.components; ++i) texel[i] = total[i] / count;
}

void fill_ring(const Image &image, const Defined &before, Defined &after, int threads) {
  parallel_blocks(image.shape.height, threads, rows_at_once, [&](int begin, int end) {
    const int width = image.shape.width;
    std::vector<uint8_t> beside(width + 2), ring(width);
    for (int y = begin; y < end; ++y) {
      find_ring(before, y, width, beside, ring);
      std::copy_n(before.row(y), width, after.row(y));
      const uint8_t *next = ring.data(), *const last = next + width;
      while ((next = static_cast<const uint8_t *>(std::memchr(next, 1, last - next)))) {
        const auto x = static_cast<int>(next++ - ring.data());
        fill_texel(image, before, x, y);
        after.row(y)[x] = is_defined(image.texel(x, y), image.shape.components); // sums may overflow
      }
    }
  });
}

} // namespace

void fill_gutter(std::span<float> values, ImageShape shape, int steps, int threads) {
  const Image image{values.data(), shape};
  Defined before(shape), after(shape);
  parallel_blocks(shape.height, threads, rows_at_once, [&](int begin, int end) {
    for (int y = begin; y < end; ++y)
      for (int x = 0; x < shape.width; ++x) before.row(y)[x] = is_defined(image.texel(x, y), shape.components);
  });
  for (int step = 0; step < steps; ++step) {
    fill_ring(image, before, after, threads);
    std::swap(before, after);
  }
  parallel_blocks(shape.height, threads, rows_at_once, [&](int begin, int end) {
    std::replace_if(
        image.texel(0, begin), image.texel(0, end), [](float x) { return !std::isfinite(x); }, 0.0f);
  });
}

} // namespace paradesc
