// Bytes → the arrays of a mesh: a soup or a known surface, with any of its numbers and counts broken.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bytes.h"
#include "paradesc/paradesc.h"

namespace paradesc::fuzz {

struct Arrays {
  std::vector<float> positions, uvs, normals;
  std::vector<int32_t> corner_vertices, triangle_corners, sharp_edges;
  std::vector<uint8_t> smooth;
  pdesc_mesh_input input;
};

// Vectors of just the size that the counts say, so that reading past one is found.
std::unique_ptr<Arrays> make_arrays(Bytes &bytes);

} // namespace paradesc::fuzz
