// Results at centers → arrays over the original vertices, masks, counts and sentences.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "descriptor/results.h"
#include "mesh/halfedge.h"
#include "paradesc/paradesc.h"

namespace paradesc {

struct Field {
  std::vector<std::string> names;         // descriptors asked for, then "coverage"
  std::vector<std::vector<float>> values; // [name][vertex, component]
  std::vector<uint8_t> mask;              // (vertex_count)
  // [name, then "boundary"][texel, component] of texel evaluation, else empty; rows from v = 0 up
  std::vector<std::vector<float>> maps;
  int map_size = 0;
  pdesc_field_report report{};
  std::string warnings;
  std::string device; // the device that computed
};

// Gives every vertex the values at its point. results: of these rows of the registry, at all points.
void gather(const HalfEdges &half_edges, const CenterResults &results, std::span<const int> rows, int threads, Field &field);

} // namespace paradesc
