// The shaders' code for 16-bit floats compiled as C++, for reading such buffers back.
#pragma once

#include <glm/common.hpp>
#include <glm/ext/vector_int3.hpp>
#include <glm/ext/vector_uint2.hpp>

#include "support/math.h"

namespace paradesc::half_floats {

using namespace glm;

struct Text {
#include "paper/bake/half.glsl"
};
#undef LARGEST_REST
#undef LEAST_CODE

} // namespace paradesc::half_floats
