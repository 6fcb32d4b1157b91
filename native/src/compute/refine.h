// The stages between a mesh with surface maps and an engine that does not follow maps: how its triangles are divided, the pieces,
// and where the maps take them.
#pragma once

#include "compute/mesh.h"

namespace paradesc {

// Whether a computation there has the mesh divided for its maps, told before there is an engine. backend: any but AUTO.
bool is_divided(const Mesh &mesh, int32_t backend);

const DivisionPlan &division_plan_of(Mesh &mesh, const pdesc_options &options);

// What the maps make of the mesh. It borrows from the mesh, until that changes or another is asked for.
Surface refined_surface_of(Mesh &mesh, const pdesc_options &options);

// Gives back what is kept for it.
void forget_refined_surface(Mesh &mesh);

// That the pieces and their places take, beside the mesh.
int64_t bytes_of_refined_surface(const Mesh &mesh, const DivisionPlan &plan);

} // namespace paradesc
