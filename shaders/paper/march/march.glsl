// A march is a sample's straight path through the UV map, across any seams, to the texel where it lands (paper 3.4, with the
// affine map of each seam edge instead of eq. 2 and 3). Lengths are in texels.
#include "paper/evaluate/buffers.glsl"
layout(binding = UNIT_BORDER) uniform isampler2D border;
layout(binding = UNIT_BORDER_LIST) uniform isamplerBuffer border_list;
layout(binding = UNIT_BORDER_UV) uniform samplerBuffer border_uv;
layout(binding = UNIT_LINKS) uniform samplerBuffer links;
#if PAPER
#define MAX_JUMPS 64 // the paper's pattern is repeated within max_jumps; marches go further, to find what that leaves out
#else
#define MAX_JUMPS params.max_jumps
#endif

const int FOUND = 0;
const int BOUNDARY = 1; // met the end of the surface
const int LOST = 2;     // too many jumps, or a position that no texel carries

struct March {
  vec2 from;
  vec2 to;
  int chart;
  int jumps;
  mat2 linear; // the linear part of the maps applied
  vec2 origin; // the image of the march's start by them
  int outcome;
};

March begin_march(vec2 from, vec2 to, int chart) { return March(from, to, chart, 0, mat2(1.0), from, FOUND); }

// The area that a sample stands for at the march's end, relative to its start.
float area_factor(March march) { return abs(determinant(march.linear)); }

#if PAPER
// advance() calls this after each jump, with the border edge that the march left through.
void mark(March march, int edge);
#endif

float cross_product(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// The first edge of this texel through which a march leaves its chart, as its index in the list, or -1; `t` becomes the march's
// parameter there. Only edges that the march crosses to their right count: others lie behind it or belong to a neighboring chart.
int first_exit(ivec2 cell, March march, int came_from, float limit, inout float t) {
  vec2 way = march.to - march.from;
  int exit_edge = -1;
  for (int i = 0; i < -cell.x; ++i) {
    ivec2 entry = texelFetch(border_list, cell.y + i).xy;
    if (entry.y != march.chart || entry.x == came_from) continue;
    vec4 uv = texelFetch(border_uv, entry.x) * float(buffer_size);
    vec2 edge = uv.zw - uv.xy;
    float slope = cross_product(edge, way);
    if (slope >= 0.0) continue;
    vec2 gap = march.from - uv.xy;
    float crossing = -cross_product(edge, gap) / slope;
    float along = cross_product(gap, way) / slope;
    if (along < -1e-5 || along > 1.0 + 1e-5 || crossing < -1e-4 || crossing > limit) continue;
    limit = crossing;
    t = crossing;
    exit_edge = entry.x;
  }
  return exit_edge;
}

// Carries the rest of the march across a seam edge; returns false if there is no other side.
bool jump(inout March march, int edge, float t, out int came_from) {
  vec4 matrix = texelFetch(links, 2 * edge);
  vec4 image = texelFetch(links, 2 * edge + 1);
  came_from = int(image.z);
  if (came_from < 0) {
    march.outcome = came_from == -2 ? BOUNDARY : LOST;
    march.to = mix(march.from, march.to, t);
    return false;
  }
  vec2 origin = texelFetch(border_uv, edge).xy * float(buffer_size);
  mat2 linear = mat2(matrix.xy, matrix.zw);
  vec2 crossing = mix(march.from, march.to, t);
  vec2 goal = image.xy * float(buffer_size);
  march.from = linear * (crossing - origin) + goal;
  march.to = linear * (march.to - origin) + goal;
  march.origin = linear * (march.origin - origin) + goal;
  march.linear = linear * march.linear;
  march.chart = int(image.w);
  ++march.jumps;
  return true;
}

void advance(inout March march) {
  int came_from = -1;
  float t = 0.0;
  march.outcome = FOUND;
  for (int count = 0; count < MAX_MARCH_STEPS; ++count) {
    vec2 way = march.to - march.from;
    float span = max(length(way), 1e-6);
    vec2 position = march.from + way * t;
    ivec2 texel = clamp(ivec2(floor(position)), ivec2(0), ivec2(buffer_size - 1));
    ivec2 cell = texelFetch(border, texel, 0).xy;
    if (cell.x > 0) {
      t += float(cell.x) / span;
      if (t >= 1.0) return;
      continue;
    }
    // Leaves through the texel's far side, and goes slightly beyond it, so that rounding cannot hold the march in the texel.
    vec2 sides = vec2(texel) + step(vec2(0.0), way) - position;
    vec2 ways = vec2(abs(way.x) > 1e-12 ? sides.x / way.x : 1e9, abs(way.y) > 1e-12 ? sides.y / way.y : 1e9);
    float leave = t + max(min(ways.x, ways.y), 0.0) + 1e-3 / span;
    if (cell.x < 0) {
      int edge = first_exit(cell, march, came_from, min(leave, 1.0), t);
      if (edge >= 0) {
        if (march.jumps == MAX_JUMPS) {
          march.outcome = texelFetch(links, 2 * edge + 1).z == -2.0 ? BOUNDARY : LOST;
          return;
        }
        if (!jump(march, edge, t, came_from)) return;
#if PAPER
        mark(march, edge);
#endif
        t = 0.0;
        continue;
      }
    }
    t = leave;
    if (t >= 1.0) return;
  }
  march.outcome = LOST;
}

// Finds the chart's texel nearest to a position on it: the texel around it or, if another chart owns that, an adjacent one.
bool find_texel(vec2 position, int chart, out ivec2 texel) {
  texel = clamp(ivec2(floor(position)), ivec2(0), ivec2(buffer_size - 1));
  if (texelFetch(ids, texel, 0).x == chart) return true;
  float nearest = 1e9;
  ivec2 own = texel;
  for (int i = 0; i < 9; ++i) {
    ivec2 beside = own + ivec2(i % 3 - 1, i / 3 - 1);
    if (any(lessThan(beside, ivec2(0))) || any(greaterThanEqual(beside, ivec2(buffer_size)))) continue;
    vec2 gap = vec2(beside) + 0.5 - position;
    float distance = dot(gap, gap);
    if (distance >= nearest || texelFetch(ids, beside, 0).x != chart) continue;
    nearest = distance;
    texel = beside;
  }
  return nearest < 1e9;
}
