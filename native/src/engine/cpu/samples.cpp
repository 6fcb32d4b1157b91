// Converts vectors to plain floats, outside of the files that are compiled per instruction set.
#include "engine/cpu/samples.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace paradesc {

// The corners are at (-2 sqrt(2), 0) and (sqrt(2), +-sqrt(6)) along both directions.
static float reach_of(const Sample &sample) {
  constexpr float rounding = 1.00001f;
  const vec3 first = sample.along[0], second = sample.along[1];
  const float square = dot(first, first),
              beside = 2.0f * square + 6.0f * dot(second, second) + 6.9282032f * std::abs(dot(first, second));
  return rounding * std::sqrt(std::max(8.0f * square, beside));
}

FlatSample flat(const Sample &sample, bool is_cluster) {
  FlatSample to{};
  const auto copy = [](vec3 from, float *floats) { std::copy_n(&from.x, 3, floats); };
  copy(sample.position, to.position);
  copy(sample.normal, to.normal);
  copy(sample.face, to.face);
  for (int k = 0; k < 2; ++k) {
    copy(sample.along[k], to.along[k]);
    copy(sample.normal_along[k], to.normal_along[k]);
  }
  to.area = sample.area;
  to.is_cluster = is_cluster ? 1.0f : 0.0f;
  to.noise = sample.noise;
  to.facet = sample.facet;
  to.reach = reach_of(sample);
  return to;
}

} // namespace paradesc
