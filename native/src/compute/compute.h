// A mesh and options → a value of each descriptor at every vertex.
#pragma once

#include "compute/mesh.h"
#include "gather/field.h"

namespace paradesc {

// descriptors: rows of the registry. Throws Error; the mesh stays usable.
Field compute(Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors, const Progress &progress);

} // namespace paradesc
