// A surface and options → values at its points, and images over its UV map: everything that is the same for all engines.
#pragma once

#include "compute/mesh.h"
#include "gather/field.h"

namespace paradesc {

// Returns values at the points of the mesh, and fills in the field's report and maps. Throws Error: CANCELLED, or the failure.
// The mesh's session stays usable.
CenterResults evaluate(Mesh &mesh, const Surface &surface, const Request &request, const Progress &progress, Field &field);

} // namespace paradesc
