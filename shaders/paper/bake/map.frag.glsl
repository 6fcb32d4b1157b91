#version 450 core
// A texel of a layout → the interpolated value of a map.
#include "paper/bake/owner.glsl"
layout(binding = UNIT_VALUES) uniform samplerBuffer values;
layout(location = 0) out vec4 map;

vec4 value_of(int corner) { return texelFetch(values, corner); }

void main() {
  int triangle;
  vec3 part;
  bool owned = find_owner(ivec2(gl_FragCoord.xy), triangle, part);
  int corner = 3 * triangle;
  map = owned ? value_of(corner) * part.x + value_of(corner + 1) * part.y + value_of(corner + 2) * part.z : vec4(0.0);
}
