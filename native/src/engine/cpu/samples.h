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

FlatSample flat(const Sample &sample, bool is_cluster);

// A triangle that would have more samples than this is divided anew for each group of centers, only where it is near them.
inline constexpr float max_stored_samples = 256;

struct SampleList {
  UnsetVector<FlatSample> sample;
  UnsetVector<SampleMap> map; // one per sample, or empty without a map
};

} // namespace paradesc
