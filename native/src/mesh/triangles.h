// The caller's arrays → a checked triangle list of our own: every index in range, every float finite.
#pragma once

#include <cstdint>
#include <vector>

#include "paradesc/paradesc.h"
#include "support/math.h"

namespace paradesc {

struct Triangles {
  int vertex_count = 0;
  int triangle_count = 0;
  std::vector<vec3> positions;          // (vertex_count)
  std::vector<int32_t> corner_vertex;   // (3 * triangle_count)
  std::vector<vec2> corner_uv;          // (3 * triangle_count) mapped into the unit square, or empty: no UV map
  std::vector<vec2> given_uv;           // (3 * triangle_count) as the caller gave them, or empty: corner_uv is that
  std::vector<int32_t> input_corner;    // (3 * triangle_count) the caller's corner
  int corner_count = 0;                 // of the caller's corners
  std::vector<vec3> corner_normal;      // (3 * triangle_count) or empty: none given
  std::vector<uint8_t> half_edge_sharp; // (3 * triangle_count) 1: the edge is marked sharp and this face is smooth
  bool uv_remapped = false;
};

// Throws Error(INVALID_ARGUMENT) with the first offender.
Triangles read_triangles(const pdesc_mesh_input &input);

// Throws Error(INVALID_ARGUMENT) where a coordinate is not finite or a count does not fit.
void set_positions(Triangles &triangles, const float *positions, int32_t vertex_count);

} // namespace paradesc
