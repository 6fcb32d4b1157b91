// Converts vectors to plain floats, outside of the files that are compiled per instruction set.
#include "engine/cpu/samples.h"

#include <algorithm>
#include <limits>

namespace paradesc {

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
  return to;
}

} // namespace paradesc
