// An image that is undefined off the surface → one whose values extend around every chart, for lookups that blend texels.
#pragma once

#include <span>

namespace paradesc {

struct ImageShape {
  int width = 0, height = 0, components = 0;
};

// Fills undefined texels in rings, one per step, with the mean of the defined ones among their eight neighbors; texels that
// remain undefined become 0. A texel is undefined if one of its components is not finite.
void fill_gutter(std::span<float> image, ImageShape shape, int steps, int threads);

} // namespace paradesc
