// An image that is undefined off the surface → one whose values go on around every chart, for lookups that blend texels.
#pragma once

#include <span>

namespace paradesc {

struct ImageShape {
  int width = 0, height = 0, components = 0;
};

// Fills undefined texels in rings, one a step, by the mean of the defined ones among their eight neighbors; what is undefined
// then becomes 0. A texel is undefined where one of its components is not finite.
void fill_gutter(std::span<float> image, ImageShape shape, int steps, int threads);

} // namespace paradesc
