// A triangle → its samples: one if it is small, several if it is large or its normals turn.
#pragma once

#include <limits>

#include "engine/cpu/samples.h"

namespace paradesc {

struct SampledTriangle {
  vec3 position[3], normal[3]; // of the corners; normals have length 1
  vec4 map[3];                 // at the corners: gradient and value, if there is a map
  float noise = 0;             // as in a Sample
};

// The sample of the undivided triangle.
Sample sample_of(const SampledTriangle &triangle);

// The largest samples that a triangle may be divided into, as mean squared distances from their middles along each direction.
struct SampleLimit {
  float largest_spread = 0; // where normals hardly turn
  // Returns the limit for this squared turn of the normals; see squared_turn(). The limit falls as they turn, since a sample
  // cannot represent normals that vary nonlinearly.
  float at(float turn) const;
};
float squared_turn(vec3 a, vec3 b, vec3 c); // the largest squared distance between the normals, if they had length 1; approximate

struct SampleCount {
  float samples; // approximate; at least 1
  bool is_small; // one sample represents the triangle
};
SampleCount count_samples(const SampledTriangle &triangle, const SampleLimit &limit);

// A ball that surrounds everything of interest.
struct Vicinity {
  vec3 middle{0.0f};
  float reach = std::numeric_limits<float>::max();
};

// Adds the samples of a large triangle, except those that lie outside of the vicinity.
void divide_triangle(const SampledTriangle &triangle, const SampleLimit &limit, const Vicinity &vicinity, bool has_map,
                     SampleList &samples);

// Interpolates values at corners.
SampleMap map_of_triangle(const vec4 (&values)[3]);
SampleMap flat(vec4 mean, vec4 first, vec4 second);

} // namespace paradesc
