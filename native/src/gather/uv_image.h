// Values at the corners of triangles → a square image over their UVs. Uses the processor alone, on every system.
#pragma once

#include <span>

#include "paradesc/paradesc.h"

namespace paradesc {

inline constexpr int most_components = 6; // of a drawn value

// Draws a checked input into (size, size, components) floats. Throws Error(CANCELLED) if the input's progress callback cancels.
// Threads draw different rows, and each texel is independent of all others.
void draw_uv_image(const pdesc_uv_image_input &input, std::span<float> image);

} // namespace paradesc
