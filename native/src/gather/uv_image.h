// Values at the corners of triangles → a square image over their UVs. By processor alone: every backend and system has it.
#pragma once

#include <span>

#include "paradesc/paradesc.h"

namespace paradesc {

inline constexpr int most_components = 6; // of a value that is drawn

// Draws what the input says, which has been checked, into (size, size, components) floats; throws Error(CANCELLED) where the
// input's progress says stop. Other threads draw other rows, and what a texel shows depends on itself alone.
void draw_uv_image(const pdesc_uv_image_input &input, std::span<float> image);

} // namespace paradesc
