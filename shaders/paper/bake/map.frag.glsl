#version 450 core
// A texel of a layout → the interpolated value of a map.
#include "paper/bake/owner.glsl"
layout(binding = UNIT_VALUES) uniform samplerBuffer values;
layout(location = 0) out vec4 map;

vec4 value_of(int vertex) { return texelFetch(values, vertex); }

void main() {
  int triangle;
  ivec4 vertex;
  vec3 part;
  bool owned = find_owner(ivec2(gl_FragCoord.xy), triangle, vertex, part);
  map = owned ? value_of(vertex.x) * part.x + value_of(vertex.y) * part.y + value_of(vertex.z) * part.z : vec4(0.0);
}
