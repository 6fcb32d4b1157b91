#version 450 core
// Triangle in (u, v) → the texels whose centers it owns: its chart and number, and the center's place in the triangle.
#include "paper/bake/metric.glsl"
layout(location = LOCATION_BUFFER_SIZE) uniform int buffer_size;

flat in int triangle;
layout(location = 0) out ivec2 ids;
layout(location = 1) out vec2 weights;

// The parameter of the point nearest to the origin on a segment that starts at a.
float nearest_on(vec2 a, vec2 way) { return clamp(-dot(a, way) / max(dot(way, way), 1e-30), 0.0, 1.0); }

// Weights of corners 1 and 2 at the triangle's point nearest to the origin, relative to which the corners are given. Rasterizers
// round corners to 1/256 of a texel: an owner may miss the center by that much, and a sliver by many times its own width.
vec2 nearest_weights(vec2 c0, vec2 c1, vec2 c2) {
  float area = cross2(c1 - c0, c2 - c0);
  vec3 inside = vec3(cross2(c1, c2), cross2(c2, c0), cross2(c0, c1)) / (abs(area) > 0.0 ? area : 1.0);
  if (abs(area) > 0.0 && all(greaterThanEqual(inside, vec3(0.0)))) return inside.yz;
  float t0 = nearest_on(c0, c1 - c0), t1 = nearest_on(c1, c2 - c1), t2 = nearest_on(c2, c0 - c2);
  vec2 p0 = mix(c0, c1, t0), p1 = mix(c1, c2, t1), p2 = mix(c2, c0, t2);
  vec3 away = vec3(dot(p0, p0), dot(p1, p1), dot(p2, p2));
  if (away.x <= away.y && away.x <= away.z) return vec2(t0, 0.0);
  return away.y <= away.z ? vec2(1.0 - t1, t1) : vec2(0.0, 1.0 - t2);
}

void main() {
  vec2 center = gl_FragCoord.xy / float(buffer_size);
  weights = nearest_weights(uv_of(triangle, 0) - center, uv_of(triangle, 1) - center, uv_of(triangle, 2) - center);
  ids = ivec2(chart_of(triangle), triangle);
}
