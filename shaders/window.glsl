// A center's windows into the UV map, and what decides whether a place is in the ball.
#include "buffers.glsl"
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_WINDOWS) restrict buffer Windows { WindowData windows[]; };
layout(std430, binding = BINDING_SEARCH) restrict buffer Searches { vec4 searches[]; };
layout(location = 2) uniform int first;
layout(location = 3) uniform int last;
layout(location = 6) uniform float radius;
layout(location = 7) uniform float enlargement;

bool in_ball(vec2 place, int chart, vec3 ball) {
  ivec2 texel = ivec2(floor(place));
  if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, ivec2(buffer_size)))) return false;
  return texelFetch(ids, texel, 0).x == chart && length(texelFetch(positions, texel, 0).xyz - ball) < radius;
}
