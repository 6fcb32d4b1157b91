// The ranges listed by neighborhoods.comp.glsl → a neighborhood's samples: texels, and samples of triangles without texels.
#include "opengl/evaluate/buffers.glsl"
layout(std430, binding = BINDING_NEIGHBORHOODS) readonly restrict buffer Neighborhoods { NeighborhoodRanges neighborhoods[]; };
layout(binding = UNIT_SAMPLES) uniform isamplerBuffer sample_list;
layout(binding = UNIT_RANGES) uniform isamplerBuffer ranges;
#if LISTED
layout(binding = UNIT_POINTS) uniform samplerBuffer points;
#endif
#if TEXELLESS
layout(std430, binding = BINDING_TEXELLESS) readonly restrict buffer Texelless { TexellessSample texelless[]; };
#endif

// Adds sample i of the list. part: 1, or 0 if i only fills up a group of four.
void add_sample(inout Sums sums, int i, float part) {
#if !LISTED || EXACT || FACES || MAP
  ivec2 entry = texelFetch(sample_list, i).xy, texel = ivec2(entry.x & 0xffff, entry.x >> 16);
#else
  const ivec2 texel = ivec2(0);
#endif
#if LISTED
  vec4 point = texelFetch(points, 2 * i), normal = texelFetch(points, 2 * i + 1);
  add_point(sums, point.xyz, normal.xyz, part * point.w, normal.w, texel, -1.0);
#else
  add_texel(sums, texel, part * intBitsToFloat(entry.y), -1.0);
#endif
}

// There is one loop over all ranges instead of nested ones, which would run as often as the longest range among neighboring
// invocations. Software devices run both sides of every branch in it, so four samples share one test for the next range.
void add_texels(inout Sums sums, int range, int end_range) {
  int i = 0, last = -1;
  for (;;) {
    if (i > last) {
      if (range == end_range) break;
      ivec2 next = texelFetch(ranges, range++).xy; // never empty
      i = next.x;
      last = next.y - 1;
    }
    add_sample(sums, i, 1.0);
    add_sample(sums, min(i + 1, last), i + 1 <= last ? 1.0 : 0.0);
    add_sample(sums, min(i + 2, last), i + 2 <= last ? 1.0 : 0.0);
    add_sample(sums, min(i + 3, last), i + 3 <= last ? 1.0 : 0.0);
    i += 4;
  }
}

void add_texelless_samples(inout Sums sums, int range, int end_range, float share) {
#if TEXELLESS
  int i = 0, end = 0;
  for (;;) {
    if (i == end) {
      if (range == end_range) break;
      ivec2 next = texelFetch(ranges, range++).xy;
      i = next.x;
      end = next.y;
    }
    TexellessSample one = texelless[i];
    vec3 offset = one.position - sums.center.position;
    if (is_connected(one.triangle))
      add_neighbor(sums, one.position, one.normal, face_of(one.triangle), share * one.area,
                   dot(offset, offset) < one.area, -1.0, MAP_OF_TEXELLESS(i));
    ++i;
  }
#endif
}

#if ADAPTIVE
// Samples the black squares of a chessboard first (part 0), then the white ones.
void sample_neighborhood(inout Sums sums, int slot, int part) {
  NeighborhoodRanges neighborhood = neighborhoods[slot];
  sums.moments.hits_boundary = neighborhood.hits_boundary;
  sums.moments.missing_area = neighborhood.missing_area;
  add_texels(sums, part == 0 ? neighborhood.first : neighborhood.middle, part == 0 ? neighborhood.middle : neighborhood.last);
  add_texelless_samples(sums, neighborhood.last, neighborhood.end, 0.5);
}
#else
void sample_neighborhood(inout Sums sums, int slot) {
  NeighborhoodRanges neighborhood = neighborhoods[slot];
  sums.moments.hits_boundary = neighborhood.hits_boundary;
  sums.moments.missing_area = neighborhood.missing_area;
  add_texels(sums, neighborhood.first, neighborhood.last);
  add_texelless_samples(sums, neighborhood.last, neighborhood.end, 1.0);
}
#endif

// The deviation from a disk's moments from which a center's triangles are checked: a single sheet is connected unless it is far
// from a disk.
float ambiguous_from(int slot, float tolerance) {
  return neighborhoods[slot].single_sheet != 0 ? 2.0 * tolerance + 0.1 : tolerance;
}
