// A texel of a layout → the corners that it lies between, and how near it is to each.
#include "opengl/bake/metric.glsl"
layout(binding = UNIT_IDS) uniform isampler2D ids;
layout(binding = UNIT_WEIGHTS) uniform sampler2D weights;

// False where nothing owns the texel.
bool find_owner(ivec2 texel, out int triangle, out ivec4 vertex, out vec3 part) {
  ivec2 id = texelFetch(ids, texel, 0).xy;
  triangle = id.x < 0 ? 0 : id.y < 0 ? -1 - id.y : id.y;
  vertex = texelFetch(corners, triangle);
  vec2 rest = texelFetch(weights, texel, 0).xy;
  part = vec3(1.0 - rest.x - rest.y, rest);
  return id.x >= 0;
}
