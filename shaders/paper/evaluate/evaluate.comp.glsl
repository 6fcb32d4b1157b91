#version 450 core
// One invocation per center → every requested descriptor, from one sampling of its neighborhood (paper 4.1).
#include "variant.glsl"
#include "device.glsl"
#include "paper/evaluate/params.glsl"
#include "kernel/sums.glsl"
#include "descriptors.glsl"
#include "paper/evaluate/buffers.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_RESULTS) writeonly restrict buffer Results { uint results[]; }; // bits of floats, which keep NaN
#if MAP
layout(binding = UNIT_MAP) uniform sampler2D maps;
layout(std430, binding = BINDING_MAP_CENTERS) readonly restrict buffer MapCenters { vec4 map_centers[]; };
#endif
#if FACES
layout(binding = UNIT_FACES) uniform samplerBuffer faces;
#endif

// Adds one texel. cell: the area in (u, v) that it stands for.
void add_texel(inout Sums sums, ivec2 texel, float cell, float geodesic) {
  vec3 normal, face = vec3(0.0);
  vec4 point = surface_at(texel, normal), map = vec4(0.0);
#if FACES
  int triangle = texelFetch(ids, texel, 0).y;
  face = texelFetch(faces, triangle < 0 ? -1 - triangle : triangle).xyz;
#endif
#if MAP
  map = texelFetch(maps, texel, 0);
#endif
  bool near = length(point.xyz - sums.center.position) < extent_of_texel(point.w);
  add_neighbor(sums, point.xyz, normal, face, point.w * cell, near, geodesic, map);
}

#include "paper/march/walks.glsl"
#if PAPER
#include "paper/march/paper.glsl"
#else
#include "paper/march/affine.glsl"
#endif

// Takes the samples of this dispatch. Returns false if later dispatches take more.
bool take_samples(inout Sums sums, CenterData data, int index, int slot, out float scale) {
  bool refined = true;
  if (params.begin_sample > 0 || (PAPER == 1 && params.marks_only == 0)) {
    sums = progress[slot].sums;
    refined = progress[slot].refined != 0;
  }
#if ADAPTIVE
  if (params.begin_sample == first_half() && params.marks_only == 0) refined = sums.moments.hits_boundary > 0.0 || is_rough(sums.moments);
#endif
  SamplingEllipse ellipse = sampling_ellipse_of(data, index);
#if PAPER
  first_visit = slot * MAX_VISITS;
  visit_count = progress[slot].visit_count;
  if (params.marks_only != 0) {
    bool left = mark_charts(sums, ellipse);
    progress[slot].left = left || (params.begin_sample > 0 && progress[slot].left != 0) ? 1 : 0;
    progress[slot].visit_count = visit_count;
  } else if (refined) {
    sample_neighborhood(sums, ellipse, progress[slot].left != 0);
  }
#else
  if (refined) sample_neighborhood(sums, ellipse);
#endif
  scale = refined ? 1.0 : 2.0;
  if (params.marks_only == 0 && params.end_sample == params.samples) return true;
  progress[slot].sums = sums;
  progress[slot].refined = refined ? 1 : 0;
  return false;
}

void main() {
  // Software devices give each core a row of groups. Interleaving the groups balances the cores if costly centers are neighbors.
  int group = int(gl_WorkGroupID.x), even = (int(gl_NumWorkGroups.x) + 1) / 2;
  group = group < even ? 2 * group : 2 * (group - even) + 1;
  int slot = group * GROUP_SIZE + int(gl_LocalInvocationID.x), index = params.first + slot;
  if (index >= params.last) return;
  CenterData data = centers[index];
  Sums sums;
#if MAP
  sums_init(sums, data.position, data.normal, map_centers[index].w);
#else
  sums_init(sums, data.position, data.normal, 0.0);
#endif
  float scale;
  if (!take_samples(sums, data, index, slot, scale)) return;

  Moments m = sums.moments;
  Neighborhood neighborhood = finish_neighborhood(sums, scale);
  float coverage = m.area > 0.0 ? m.area / (m.area + m.missing_area) : 0.0;
  uint flags = (m.hits_boundary > 0.0 ? FLAG_HITS_BOUNDARY : 0u) | (scale == 1.0 ? FLAG_ALL_SAMPLES : 0u);
  results[ROW_COVERAGE * params.total + index] = floatBitsToUint(coverage);
  results[ROW_FLAGS * params.total + index] = flags;
  STORE_DESCRIPTORS
}
