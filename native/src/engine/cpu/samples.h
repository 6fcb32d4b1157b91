// Samples of the surface in the layout that sums use.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/cpu/add_samples.h"
#include "engine/cpu/pieces.h"
#include "support/unset.h"

namespace paradesc {

// surfel: the surfel that the sample is, or is part of.
FlatSample flat(const Sample &sample, int32_t surfel);

// Returns the corners of the triangle that the sample represents, relative to the center.
std::array<vec3, 3> corners_of(const FlatSample &sample, vec3 center);

// A triangle that would have more samples than this is divided anew for each group of centers, only where it is near them.
inline constexpr float max_stored_samples = 256;

struct SampleList {
  UnsetVector<FlatSample> sample;
  UnsetVector<SampleMap> map; // one per sample, or empty without a map
};

struct SurfaceSamples {
  SampleList list;                  // samples of all surfels but the largest, in their order
  std::vector<int32_t> first;       // (surfels + 1) into the list
  UnsetVector<SampleBlock> block;   // consecutive samples that lie near each other
  UnsetVector<int32_t> block_begin; // (blocks + 1) into the list
  std::vector<int32_t> cell_block;  // (cells + 1) into block
  UnsetVector<vec4> sphere;         // (blocks) middle, radius
};

// Both take at most as many samples as a block has.
SampleBlock block_of(std::span<const FlatSample> samples);
vec4 sphere_of(std::span<const FlatSample> samples);

} // namespace paradesc
