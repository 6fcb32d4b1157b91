// A march → its length as a sum of chords (paper 5.1). A march is not a geodesic: if it bends along the surface, by kappa_g, the
// sum exceeds the distance.
#if CHORDS
#define CHORD_COUNT 8

// Interpolates the surface at a position on a chart between the chart's texels around it. Returns false if there are none.
bool surface_between(vec2 position, int chart, out vec3 point) {
  vec2 low = floor(position - 0.5);
  vec2 part = position - 0.5 - low;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 step_ = ivec2(i & 1, i >> 1);
    ivec2 texel = ivec2(low) + step_;
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, ivec2(buffer_size)))) continue;
    if (texelFetch(ids, texel, 0).x != chart) continue;
    vec2 share = mix(1.0 - part, part, vec2(step_));
    sum += vec4(texelFetch(positions, texel, 0).xyz, 1.0) * (share.x * share.y);
  }
  point = sum.xyz / max(sum.w, 1e-6);
  return sum.w > 1e-3;
}

// The length from the center to the surface's point q, by equal steps of `way` in (u, v).
float length_of_chords(vec2 from, vec2 way, int chart, vec3 p, vec3 q) {
  March march = begin_march(from, from, chart);
  float sum = 0.0;
  vec3 before = p;
  for (int i = 1; i < CHORD_COUNT; ++i) {
    march.from = march.to;
    march.to = march.from + march.linear * way / float(CHORD_COUNT);
    advance(march);
    vec3 point;
    if (march.outcome != FOUND) break;
    if (!surface_between(march.to, march.chart, point)) continue;
    sum += length(point - before);
    before = point;
  }
  return sum + length(q - before);
}
#else
float length_of_chords(vec2 from, vec2 way, int chart, vec3 p, vec3 q) { return -1.0; }
#endif
