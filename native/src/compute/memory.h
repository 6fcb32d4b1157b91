// Counts and options → the bytes that a mesh and its computations take at their peak, known before any of that is allocated.
#pragma once

#include <cstdint>
#include <span>

#include "compute/mesh.h"

namespace paradesc {

// While a mesh is made of it, beside the caller's arrays.
int64_t bytes_of_input(const pdesc_mesh_input &input);

// backend: any but AUTO.
MemoryForecast forecast_memory_of(Mesh &mesh, int backend, const pdesc_options &options, std::span<const int> descriptors);

// Throws what a mesh or a computation is too large for.
void check_memory_of_input(const Context &context, const pdesc_mesh_input &input);
void check_memory_of_compute(Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors);

} // namespace paradesc
