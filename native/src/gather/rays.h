// Rays from one surface → where they meet another, and its values there. By processor alone: every backend and system has it.
#pragma once

#include <span>

#include "paradesc/paradesc.h"

namespace paradesc {

// What the input says, which has been checked: a triangle and three weights for each ray. Throws Error(CANCELLED) where the
// input's progress says stop.
void cast_rays(const pdesc_rays_input &input, std::span<int32_t> triangles, std::span<float> weights);

// The values there; triangles have been checked.
void values_met(const pdesc_rays_input &input, const int32_t *triangles, const float *weights, const float *values,
                int components, float *met);

} // namespace paradesc
