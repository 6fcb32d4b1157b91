// Charts → the vertices of the bake, between which texels are interpolated. Depends on topology, and on which corners share a
// normal.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/charts.h"
#include "mesh/triangles.h"

namespace paradesc {

// A vertex of the bake stands for the corners of one wedge that share a normal.
struct BakeVertices {
  std::vector<int32_t> corner; // (bake vertices) one of its corners
  std::vector<int32_t> group;  // (bake vertices) as Normals::group
  std::vector<uint32_t> index; // (3 * triangle_count) bake vertex of each corner; 0 for triangles on no chart
};

// corner_group: corners of one wedge with the same group share a normal; empty: none do.
BakeVertices build_bake_vertices(const Triangles &triangles, const Charts &charts, const std::vector<int32_t> &corner_group);

} // namespace paradesc
