// shaders/kernel as C++: KERNEL<float, bool> adds one neighbor at a time and finishes; KERNEL<Lanes, Choices> adds as many as there
// are lanes, whose sums are added up before they are finished by add_lanes().
//
// No include guard: each engine, or each choice of an engine, includes it with a name of its own for KERNEL. What GLSL chooses when it
// compiles is chosen in the same way: INTEGRAL, EXTRAPOLATED, GEODESIC_BALL, FACES and MAP are 0 or 1, as are TERMS_BALL and so on for
// each of shaders/kernel/terms, 1 where nothing is said.
#include <limits>

#include "engine/kernels/lanes.h"
#include "engine/kernels/vectors.h"
#include "kernel/limits.h"
#include "support/math.h"

#include "shared.h"

namespace paradesc::kernels {
inline namespace KERNEL_TARGET {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter" // a kernel takes what any other one needs
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
