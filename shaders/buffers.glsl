// The baked buffers, fetched nearest: every texel is an exact point of the surface.
#include "shared.h"
layout(binding = UNIT_POSITION) uniform sampler2D positions;
layout(binding = UNIT_NORMAL) uniform sampler2D normals;
layout(binding = UNIT_IDS) uniform isampler2D ids;
layout(location = 0) uniform int buffer_size;
layout(location = LOCATION_AREA_UNIT) uniform float area_unit;

// Position and area element of a texel.
vec4 surface_at(ivec2 texel) {
  vec4 point = texelFetch(positions, texel, 0);
  return vec4(point.xyz, point.w * area_unit);
}
