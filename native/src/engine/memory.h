// Counts → bytes that every engine takes.
#pragma once

#include "engine/engine.h"

namespace paradesc {

// Rows of results at a center: coverage, flags, area, then one for each component of a descriptor.
int64_t rows_of(std::span<const int> descriptors);

// Normals and results, beside the mesh.
int64_t bytes_of_results(const ComputationSize &size);

} // namespace paradesc
