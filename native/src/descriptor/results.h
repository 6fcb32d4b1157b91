// What comes out of the places where descriptors are evaluated, before it goes to vertices or texels.
#pragma once

#include <cstdint>
#include <vector>

namespace paradesc {

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

} // namespace paradesc
