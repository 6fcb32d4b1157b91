// The baked buffers, fetched nearest: every texel is an exact point of the surface.
#include "shared.h"
#include "paper/bake/half.glsl"
layout(binding = UNIT_POSITION) uniform sampler2D positions;
layout(binding = UNIT_NORMAL) uniform sampler2D normals;
layout(binding = UNIT_IDS) uniform isampler2D ids;
layout(location = LOCATION_BUFFER_SIZE) uniform int buffer_size;
layout(location = LOCATION_AREA_UNIT) uniform float area_unit;

// The side of a texel in space, from its area element.
float extent_of_texel(float area_element) { return sqrt(area_element) / float(buffer_size); }

// Position and area element of a texel, and its normal.
vec4 surface_at(ivec2 texel, out vec3 normal) {
  vec4 point = texelFetch(positions, texel, 0);
  vec4 stored = texelFetch(normals, texel, 0);
#ifdef HALF_FLOATS
  point.xyz += three_of_code(stored.w);
  normal = from_octahedron(stored.xy + two_of_code(stored.z));
#else
  normal = stored.xyz;
#endif
  return vec4(point.xyz, point.w * area_unit);
}
