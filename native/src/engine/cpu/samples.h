// Samples of the surface, as sums run over them.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/cpu/add_samples.h"
#include "engine/cpu/pieces.h"

namespace paradesc {

// surfel: of which it is, or is part. map: gradient and value.
FlatSample flat(const Sample &sample, int32_t surfel, vec4 map);

// Triangles that would have more samples than this are divided anew by each group of centers, as far as it is near.
inline constexpr float max_stored_samples = 256;

struct SurfaceSamples {
  std::vector<FlatSample> sample; // of all surfels but the largest, in their order
  std::vector<int32_t> first;     // (surfels + 1) into sample
};

} // namespace paradesc
