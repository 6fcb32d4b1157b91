// Counts and options → the bytes that a mesh and its computations take at their peak, before anything is allocated.
#pragma once

#include <cstdint>
#include <span>

#include "compute/mesh.h"

namespace paradesc {

// Peak bytes while a mesh is made from this input, in addition to the caller's arrays.
int64_t bytes_of_input(const pdesc_mesh_input &input);

// backend: any but AUTO.
MemoryForecast forecast_memory_of(Mesh &mesh, int backend, const pdesc_options &options, std::span<const int> descriptors);

// Throw Error if a mesh or a computation is too large for the memory limit.
void check_memory_of_input(const Context &context, const pdesc_mesh_input &input);
void check_memory_of_compute(Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors);

} // namespace paradesc
