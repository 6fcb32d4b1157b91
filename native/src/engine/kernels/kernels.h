// shaders/kernel as C++: KERNEL<float, bool> adds one neighbor at a time and finishes; KERNEL<Lanes, Choices> adds one neighbor
// per lane. add_lanes() adds up the lanes' sums before they are finished.
//
// There is no include guard: each engine, or each variant of an engine, includes this file with its own name for KERNEL.
// Compile-time choices are the same macros as in GLSL: INTEGRAL, EXTRAPOLATED, GEODESIC_BALL, FACES and MAP are 0 or 1, as are
// TERMS_BALL and so on, one for each file of shaders/kernel/terms, which default to 1.
#include <limits>

#include "engine/kernels/lanes.h"
#include "engine/kernels/vectors.h"
#include "kernel/limits.h"
#include "support/math.h"

#include "shared.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter" // every kernel has the same parameters
#pragma GCC diagnostic ignored "-Wshadow"
#define OUT(type) type &
#define INOUT(type) type &
#define NOT_A_NUMBER std::numeric_limits<real>::quiet_NaN()
using real = float;
#define float Float
#define bool Bool

template <class Float, class Bool> struct KERNEL {
  using vec2 = Vector<2, Float>;
  using vec3 = Vector<3, Float>;
  using vec4 = Vector<4, Float>;
  using mat3 = Matrix3<Float>;
  EvaluateParams params;
  static constexpr int geodesic_ball = GEODESIC_BALL;

#include "kernel/sums.glsl"
#include "descriptors.glsl"
};

#undef bool
#undef float
#undef PI
#undef RIM_BEND
#undef NOT_A_NUMBER
#undef INOUT
#undef OUT
#pragma GCC diagnostic pop

} // namespace KERNEL_TARGET
} // namespace paradesc::kernels
