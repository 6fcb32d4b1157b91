// Surfels → the samples that sums run over: one of each small surfel, and those that large triangles are divided into.
#pragma once

#include <vector>

#include "engine/cpu/samples.h"
#include "engine/cpu/surfels.h"

namespace paradesc {

SurfaceSamples list_samples(const SurfelSource &source, const Surfels &surfels);

// Adds the samples of a large triangle that may lie nearer to the middle than the limit.
void divide_triangle(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 middle, float limit,
                     SampleList &samples);

} // namespace paradesc
