// Vectors as plain floats, which no set of instructions compiles for itself.
#include "engine/cpu/samples.h"

#include <algorithm>

namespace paradesc {

FlatSample flat(const Sample &sample, int32_t surfel, vec4 map) {
  FlatSample to;
  const auto copy = [](vec3 from, float *floats) { std::copy_n(&from.x, 3, floats); };
  copy(sample.position, to.position);
  copy(sample.normal, to.normal);
  copy(sample.face, to.face);
  for (int k = 0; k < 2; ++k) {
    copy(sample.along[k], to.along[k]);
    copy(sample.normal_along[k], to.normal_along[k]);
  }
  to.area = sample.area;
  to.per_area = 1.0f / sample.area;
  to.reach = sample.reach;
  to.turn = sample.turn;
  to.surfel = surfel;
  std::copy_n(&map.x, 4, to.map);
  return to;
}

} // namespace paradesc
