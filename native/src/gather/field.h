// Results at points and sites → arrays over the original vertices, masks, counts and sentences.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "paradesc/paradesc.h"

namespace paradesc {

struct Field {
  std::vector<std::string> names;             // descriptors asked for, then "coverage"
  std::vector<std::vector<float>> values;     // [name][vertex, component]
  std::vector<std::vector<float>> seam_error; // [name][vertex], empty where not asked for; of a direction the angle in radians
  std::vector<uint8_t> mask;                  // (vertex_count)
  std::vector<std::vector<float>> maps;       // [name][texel, component] of texel evaluation, else empty; rows from v = 0 up
  int map_size = 0;
  pdesc_field_report report{};
  std::string warnings;
};

// One place of evaluation and what came out of it.
struct SiteResults {
  std::vector<int32_t> point;             // (places) point evaluated
  std::vector<uint8_t> primary;           // (places) 1: the place that answers for the point
  std::vector<std::vector<float>> values; // [descriptor][place, component], units of the positions
  double refined_share = 1.0;             // of the places, where all samples were taken
  std::vector<float> coverage;            // (places)
  std::vector<uint8_t> boundary;          // (places)
};

// Adds the results of further places.
void append(SiteResults &all, SiteResults &&part);

// Every vertex takes its point's primary place. with_seam_error: also the spread over all places of a point.
void gather(const HalfEdges &half_edges, const SiteResults &results, bool with_seam_error, int threads, Field &field);

} // namespace paradesc
