// A texel of a layout → its owner, and the weight of each corner.
#include "paper/bake/metric.glsl"
layout(binding = UNIT_IDS) uniform isampler2D ids;
layout(binding = UNIT_WEIGHTS) uniform sampler2D weights;

// Finds the owner of a texel; returns false if there is none.
bool find_owner(ivec2 texel, out int triangle, out vec3 part) {
  ivec2 id = texelFetch(ids, texel, 0).xy;
  triangle = id.x < 0 ? 0 : id.y < 0 ? -1 - id.y : id.y;
  vec2 rest = texelFetch(weights, texel, 0).xy;
  part = vec3(1.0 - rest.x - rest.y, rest);
  return id.x >= 0;
}
