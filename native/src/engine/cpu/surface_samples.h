// Surfels → the samples that sums run over: one of each small surfel, and those that large triangles are divided into.
#pragma once

#include <vector>

#include "engine/cpu/samples.h"
#include "engine/cpu/surfels.h"

namespace paradesc {

// Triangles that would have more samples than this are divided anew by each group of centers, as far as it is near.
inline constexpr float max_stored_samples = 256;

struct SurfaceSamples {
  Samples samples;                // of all surfels but the largest, in their order
  std::vector<int32_t> first;     // (surfels + 1) into samples
  std::vector<vec4> block_sphere; // (blocks)
};

SurfaceSamples list_samples(const SurfelSource &source, const Surfels &surfels);

// Adds the samples of a large triangle that may lie nearer to the middle than the limit.
void divide_triangle(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 middle, float limit,
                     Samples &samples);

} // namespace paradesc
