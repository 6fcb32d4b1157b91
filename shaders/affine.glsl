// The golden-angle pattern over the enlarged ellipse (paper 3.4, 4.1), each sample carried over the seams by itself.
#include "neighborhood.glsl"
layout(std430, binding = BINDING_PATTERN) readonly restrict buffer Pattern { vec2 pattern[]; };

// Adaptive sampling takes every other sample first, and the rest then.
#if ADAPTIVE
void sample_support(inout Sums sums, CenterData data, int index, int part) {
  const int step_ = 2;
#else
void sample_support(inout Sums sums, CenterData data, int index) {
  const int part = 0, step_ = 1;
#endif
  float size = float(buffer_size);
  mat2 rotation = mat2(cos(data.normal_phase.w), sin(data.normal_phase.w), -sin(data.normal_phase.w), cos(data.normal_phase.w));
  mat2 ellipse = mat2(data.ellipse.xy, data.ellipse.zw) * rotation * size;
  float area_uv = PI * abs(determinant(ellipse)) / (float(samples) * size * size);
  float area_space = PI * enlargement * enlargement * radius * radius / float(samples); // where the metric is that of the center
  for (int i = part; i < samples; i += step_) {
    Walk walk = Walk(data.place.zw * size, data.place.xy * size + ellipse * pattern[i], int(data.position_chart.w), 1.0, FOUND);
    march(walk);
    ivec2 texel;
    bool carried = find_texel(walk.to, walk.chart, texel);
    if (walk.outcome == BOUNDARY) {
      if (carried && length(texelFetch(positions, texel, 0).xyz - sums.center.position) < radius) sums.moments.cut += 1.0;
    } else if (walk.outcome == LOST || !carried) {
      if (length(pattern[i]) * enlargement <= 1.0) sums.moments.lost += area_space;
    } else {
      add_texel(sums, texel, area_uv * walk.factor, -1.0);
    }
  }
}
