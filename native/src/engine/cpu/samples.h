// Samples of the surface, as sums run over them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/cpu/add_samples.h"
#include "engine/cpu/pieces.h"
#include "support/unset.h"

namespace paradesc {

// surfel: of which it is, or is part.
FlatSample flat(const Sample &sample, int32_t surfel);

// Of the triangle that it stands for, from the center.
std::array<vec3, 3> corners_of(const FlatSample &sample, vec3 center);

// Triangles that would have more samples than this are divided anew by each group of centers, as far as it is near.
inline constexpr float max_stored_samples = 256;

struct SampleList {
  UnsetVector<FlatSample> sample;
  UnsetVector<SampleMap> map; // of each; empty: there is none
};

struct SurfaceSamples {
  SampleList list;                  // of all surfels but the largest, in their order
  std::vector<int32_t> first;       // (surfels + 1) into the list
  UnsetVector<SampleBlock> block;   // of samples that follow each other, and lie near each other
  UnsetVector<int32_t> block_begin; // (blocks + 1) into the list
  std::vector<int32_t> cell_block;  // (cells + 1) into block
  UnsetVector<vec4> sphere;         // (blocks) middle, radius
};

// Of as many samples as a block has, or fewer.
SampleBlock block_of(std::span<const FlatSample> samples);
vec4 sphere_of(std::span<const FlatSample> samples);

} // namespace paradesc
