// Surfels → the samples of sums: one for each small surfel, and several for each large triangle, which is divided.
#pragma once

#include <vector>

#include "engine/cpu/samples.h"
#include "engine/cpu/surfels.h"

namespace paradesc {

SurfaceSamples list_samples(const SurfelSource &source, const Surfels &surfels);

// Adds the samples of a large triangle, except those that are farther from the middle than the limit.
void divide_triangle(const SurfelSource &source, const Surfels &surfels, int32_t surfel, vec3 middle, float limit,
                     SampleList &samples);

} // namespace paradesc
