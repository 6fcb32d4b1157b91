// A point of the surface at which descriptors are evaluated.
#pragma once

#include <cstdint>

#include "support/math.h"
#include "support/unset.h"

namespace paradesc {

struct CenterPoint {
  vec3 position;    // in units of the buffers
  vec3 normal;      // unit
  int32_t triangle; // the triangle that it lies on
  int32_t point;    // the point of the mesh that it is; or -1
};
using CenterPoints = UnsetVector<CenterPoint>;

} // namespace paradesc
