// Counts and options → the bytes that a mesh and its computations take at their peak, known before any of that is allocated.
#pragma once

#include <cstdint>
#include <span>

#include "compute/compute.h"

namespace paradesc {

// While a mesh is made of it, beside the caller's arrays.
int64_t bytes_of_input(const pdesc_mesh_input &input);

// Of a mesh, and at the peak of one computation beside it. device: textures and buffers; the host's memory too where a software
// rasterizer is the device.
struct MemoryOfCompute {
  int64_t mesh = 0, host = 0, device = 0;
};
MemoryOfCompute memory_of_compute(const Mesh &mesh, int backend, const pdesc_options &options, std::span<const int> descriptors);

// Of the host's memory: mesh, computation, and where the device is software, that.
int64_t total_of(const MemoryOfCompute &memory, int backend);

// Bytes that may be taken beside those held already: what the context's limit leaves, or half of what is free.
int64_t allowed_memory(const Context &context, int64_t held);

// Throws Error(OUT_OF_MEMORY) with both numbers where more is needed than allowed. subject: "A mesh of 17 triangles"; remedy:
// "use fewer triangles".
void check_memory(const Context &context, const std::string &subject, const std::string &remedy, int64_t needed, int64_t held);

// Throws what a mesh or a computation is too large for.
void check_memory_of_input(const Context &context, const pdesc_mesh_input &input);
void check_memory_of_compute(const Mesh &mesh, const pdesc_options &options, std::span<const int> descriptors);

} // namespace paradesc
