// Rays from one surface → the points where they meet another, and its values there. Uses the processor alone, on every system.
#pragma once

#include <span>

#include "paradesc/paradesc.h"

namespace paradesc {

// Casts the rays of a checked input: writes a triangle and three weights for each ray. Throws Error(CANCELLED) if the input's
// progress callback cancels.
void cast_rays(const pdesc_rays_input &input, std::span<int32_t> triangles, std::span<float> weights);

// Interpolates values at the hits; triangles must have been checked.
void values_met(const pdesc_rays_input &input, const int32_t *triangles, const float *weights, const float *values,
                int components, float *met);

} // namespace paradesc
