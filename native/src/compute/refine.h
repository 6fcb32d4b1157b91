// The stages between a mesh with surface maps and an engine that does not follow maps: the plan of division, the pieces, and
// their positions as displaced by the maps.
#pragma once

#include "compute/mesh.h"

namespace paradesc {

// Returns whether a computation on this backend divides the mesh for its maps; can be called before an engine is open. backend:
// not AUTO.
bool is_divided(const Mesh &mesh, int32_t backend);

const DivisionPlan &division_plan_of(Mesh &mesh, const pdesc_options &options);

// The mesh as displaced by its maps. The result borrows from the mesh; it is valid until the mesh changes or the next call.
Surface refined_surface_of(Mesh &mesh, const pdesc_options &options);

// Frees the stages of the refined surface.
void forget_refined_surface(Mesh &mesh);

// Bytes used by the refined surface, in addition to the mesh.
int64_t bytes_of_refined_surface(const Mesh &mesh, const DivisionPlan &plan);

} // namespace paradesc
