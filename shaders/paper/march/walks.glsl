// Samples that march (affine, paper). Each dispatch takes some samples of a pattern and passes the sums on to the next one, so
// that none comes near the iterations that a device allows an invocation.
#include "paper/march/march.glsl"
#include "paper/march/pattern.glsl"
#include "paper/march/chords.glsl"

struct Progress {
  Sums sums;
  int refined;     // adaptive sampling takes the second half
  int visit_count; // paper
  int left;        // paper: samples that left the center's chart
};
layout(std430, binding = BINDING_PROGRESS) restrict buffer Progresses { Progress progress[]; };

// Adaptive sampling takes every other sample first, then the rest.
int first_half() { return (params.samples + 1) / 2; }
int sample_number(int i) {
#if ADAPTIVE
  return i < first_half() ? 2 * i : 2 * (i - first_half()) + 1;
#else
  return i;
#endif
}

struct SamplingEllipse {
  mat2 rotation;
  mat2 axes; // in texels
  vec2 center;
  vec2 start; // start of its marches
  int chart;
  int index;
  float area_uv;    // of a sample
  float area_space; // of a sample, if the metric is that of the center
};

SamplingEllipse sampling_ellipse_of(CenterData data, int index) {
  float size = float(buffer_size);
  mat2 axes = mat2(data.ellipse.xy, data.ellipse.zw) * size;
  float angle = data.phase;
  return SamplingEllipse(mat2(cos(angle), sin(angle), -sin(angle), cos(angle)), axes, data.uv.xy * size, data.uv.zw * size,
               data.chart, index, PI * abs(determinant(axes)) / (float(params.samples) * size * size),
               PI * params.enlargement * params.enlargement * params.radius * params.radius / float(params.samples));
}

// Marches to a sample's position across the seams, as far as possible.
March march_to(SamplingEllipse ellipse, PatternSample goal) {
  March march = begin_march(ellipse.start, ellipse.center + ellipse.axes * goal.disk, ellipse.chart);
  advance(march);
  return march;
}

// Returns whether the mesh's boundary stopped this march within the ball.
bool hits_boundary(March march, Center center) {
  ivec2 texel;
  if (march.outcome != BOUNDARY || !find_texel(march.to, march.chart, texel)) return false;
  return length(texelFetch(positions, texel, 0).xyz - center.position) < params.radius;
}

// Adds a sample that its march, or its visit, has carried to `there`.
void add_sample(inout Sums sums, SamplingEllipse ellipse, PatternSample goal, vec2 there, int chart, float factor) {
  float share = goal.stretch * goal.stretch;
  ivec2 texel;
  if (!find_texel(there, chart, texel)) {
    if (goal.inside) sums.moments.missing_area += ellipse.area_space * share;
    return;
  }
  vec3 point = texelFetch(positions, texel, 0).xyz;
  vec2 way = ellipse.center + ellipse.axes * goal.disk - ellipse.start;
  add_texel(sums, texel, ellipse.area_uv * share * factor, length_of_chords(ellipse.start, way, ellipse.chart, sums.center.position, point));
}

// Adds the area of samples that an iteration limit cut off: `count` out of `of` samples.
void miss_rest(inout Sums sums, int count, int of) {
  if (count > 0) sums.moments.missing_area += PI * params.radius * params.radius * float(count) / float(of);
}
