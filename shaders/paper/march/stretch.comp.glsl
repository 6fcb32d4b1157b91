#version 450 core
// One invocation per direction of a center → the stretch of the ellipse in it: the largest length in (u, v) per length in space
// on the march, relative to the center's (paper 4.1).
#include "variant.glsl"
#include "device.glsl"
#include "paper/evaluate/params.glsl"
#include "paper/march/march.glsl"
#include "paper/bake/metric.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_STRETCHES) writeonly restrict buffer Stretches { float stretches[]; };

const int STEPS = 8;       // along the ellipse's own radius
const float LARGEST = 4.0; // stretch

// The length in space of a step in (u, v), both relative to the whole path; below 0 if there is no texel.
float length_in_space(vec2 step_uv, vec2 position, int chart) {
  ivec2 texel;
  if (!find_texel(position, chart, texel)) return -1.0;
  int id = texelFetch(ids, texel, 0).y;
  vec4 form = form_of(id < 0 ? -1 - id : id);
  return sqrt(max(form.x * step_uv.x * step_uv.x + 2.0 * form.y * step_uv.x * step_uv.y + form.z * step_uv.y * step_uv.y, 0.0));
}

void main() {
  int index = params.first * STRETCH_DIRECTIONS + int(gl_GlobalInvocationID.x);
  if (index >= params.last * STRETCH_DIRECTIONS) return;
  CenterData data = centers[index / STRETCH_DIRECTIONS];
  float size = float(buffer_size);
  float angle = 2.0 * 3.14159265358979 * float(index % STRETCH_DIRECTIONS) / float(STRETCH_DIRECTIONS);
  vec2 way = mat2(data.ellipse.xy, data.ellipse.zw) * vec2(cos(angle), sin(angle)) * size;
  vec2 start = data.uv.zw * size;
  March march = begin_march(start, start, data.chart);
  float stretch = 1.0, reached = 0.0;
  for (int i = 1; i <= int(LARGEST) * STEPS; ++i) {
    march.from = march.to;
    march.to = march.from + march.linear * way / float(STEPS);
    advance(march);
    if (march.outcome != FOUND) break;
    float span = length_in_space(march.linear * way / size, march.to, march.chart) / (params.enlargement * params.radius);
    if (span < 0.0) continue;
    stretch = clamp(1.0 / max(span, 1e-6), stretch, LARGEST);
    reached += span / float(STEPS);
    if (reached >= 1.0 || float(i) >= stretch * float(STEPS)) break;
  }
  stretches[index] = stretch;
}
