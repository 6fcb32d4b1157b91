// Cells + positions of a frame → the neighborhood of each center: the cells of the surface connected to it within the ball, and
// samples of the triangles that no texel carries.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "mesh/normals.h"
#include "sample/cells.h"

namespace paradesc {

// The cells of each center's neighborhood.
struct Supports {
  std::vector<ivec2> range;      // (centers) first and count, into cell
  std::vector<int32_t> cell;     // -1 - cell: near the center, to be sampled more finely
  std::vector<uint8_t> boundary; // (centers) 1: the mesh's boundary lies in the ball
};

struct SupportCenter {
  vec3 position;                  // buffer units
  std::span<const int32_t> sites; // to start from
  int32_t cell;                   // to start from as well, or -1
};

// Triangles that no texel carries count all the same, by samples of their own.
struct BareSamples {
  std::vector<int32_t> begin; // (cells + 1)
  std::vector<vec4> point;    // two a sample: position in buffer units, area; normal, triangle (exact up to 2^24)
  std::vector<vec2> weights;  // (samples) of the triangle's corners 1 and 2: where the sample lies
};

// mapped: the surface over the triangles where maps displace it, else NULL.
BareSamples sample_bare_triangles(const Cells &cells, const Triangles &triangles, const Normals &normals,
                                  const BufferFrame &frame, float radius, const MappedSurface *mapped = nullptr);

// positions: (size * size) as GeometryBuffer::read_position. radius in buffer units. Throws Error(OUT_OF_MEMORY) where all
// neighborhoods together have more cells than `most`, or than can be counted.
Supports find_supports(const Cells &cells, const std::vector<vec4> &positions, const Triangles &triangles,
                       const BufferFrame &frame, const std::vector<SupportCenter> &centers, float radius, int threads,
                       size_t most = std::numeric_limits<int32_t>::max());

} // namespace paradesc
