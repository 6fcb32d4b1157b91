// The caller's arrays → a checked triangle list of our own: every index in range, every float finite.
#pragma once

#include <cstdint>
#include <vector>

#include "paradesc/paradesc.h"
#include "support/math.h"
#include "support/shared_array.h"

namespace paradesc {

struct Triangles {
  int vertex_count = 0;
  int triangle_count = 0;
  std::vector<vec3> positions;          // (vertex_count)
  std::vector<int32_t> corner_vertex;   // (3 * triangle_count)
  SharedArray<vec2> input_uv;           // (3 * triangle_count) as the caller gave them, or empty: no UV map
  SharedArray<vec2> corner_uv;          // the same, moved into the unit square where it lies outside
  std::vector<int32_t> input_corner;    // (3 * triangle_count) the caller's corner
  int corner_count = 0;                 // of the caller's corners
  std::vector<vec3> corner_normal;      // (3 * triangle_count) or empty: none given
  std::vector<uint8_t> half_edge_sharp; // (3 * triangle_count) 1: the edge is marked sharp and this face is smooth
  bool uv_remapped = false;

  const vec3 &position(int32_t corner) const { return positions[corner_vertex[corner]]; }
};

// Throws Error(INVALID_ARGUMENT) that names the first index or coordinate that cannot be used.
Triangles read_triangles(const pdesc_mesh_input &input);

// Throws Error(INVALID_ARGUMENT) if a coordinate is not finite or a count does not fit.
void set_positions(Triangles &triangles, const float *positions, int32_t vertex_count);

} // namespace paradesc
