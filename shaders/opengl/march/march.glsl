// A sample's straight way through the UV map → the texel where it lands, over any seams (paper 3.4, with the affine map of each seam
// edge in place of eq. 2 and 3). Lengths are in texels.
#include "opengl/evaluate/buffers.glsl"
layout(binding = UNIT_BORDER) uniform isampler2D border;
layout(binding = UNIT_BORDER_LIST) uniform isampler2D border_list;
layout(binding = UNIT_BORDER_UV) uniform sampler2D border_uv;
layout(binding = UNIT_LINKS) uniform sampler2D links;
#if PAPER
#define MOST_JUMPS 64 // the paper's pattern is repeated within max_jumps; marches go on and tell what that leaves out
#else
#define MOST_JUMPS params.max_jumps
#endif

const int FOUND = 0;
const int BOUNDARY = 1; // met the end of the surface
const int LOST = 2;     // too many jumps, or a place that no texel carries

struct Walk {
  vec2 from;
  vec2 to;
  int chart;
  int jumps;
  mat2 linear; // the linear part of the maps applied
  vec2 origin; // the image of the walk's start by them
  int outcome;
};

Walk begin_walk(vec2 from, vec2 to, int chart) { return Walk(from, to, chart, 0, mat2(1.0), from, FOUND); }

// The area of a cell of the pattern at the walk's end, relative to its start.
float area_factor(Walk walk) { return abs(determinant(walk.linear)); }

#if PAPER
// Called wherever a walk has jumped, with the border edge that it left through.
void mark(Walk walk, int edge);
#endif

float cross_product(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// The first edge of this texel through which a walk leaves its chart, as its place in the list, or -1; `t` becomes the place on the
// walk. Only edges with the walk going out to their right count: the others are behind it or belong to a neighboring chart.
int first_exit(ivec2 cell, Walk walk, int came_from, float limit, inout float t) {
  vec2 way = walk.to - walk.from;
  int exit_edge = -1;
  for (int i = 0; i < -cell.x; ++i) {
    ivec2 entry = texelFetch(border_list, list_place(cell.y + i), 0).xy;
    if (entry.y != walk.chart || entry.x == came_from) continue;
    vec4 uv = texelFetch(border_uv, list_place(entry.x), 0) * float(buffer_size);
    vec2 edge = uv.zw - uv.xy;
    float slope = cross_product(edge, way);
    if (slope >= 0.0) continue;
    vec2 gap = walk.from - uv.xy;
    float place = -cross_product(edge, gap) / slope;
    float along = cross_product(gap, way) / slope;
    if (along < -1e-5 || along > 1.0 + 1e-5 || place < -1e-4 || place > limit) continue;
    limit = place;
    t = place;
    exit_edge = entry.x;
  }
  return exit_edge;
}

// Carries the rest of the walk over a seam edge; false where there is no other side.
bool jump(inout Walk walk, int edge, float t, out int came_from) {
  vec4 matrix = texelFetch(links, list_place(2 * edge), 0);
  vec4 image = texelFetch(links, list_place(2 * edge + 1), 0);
  came_from = int(image.z);
  if (came_from < 0) {
    walk.outcome = came_from == -2 ? BOUNDARY : LOST;
    walk.to = mix(walk.from, walk.to, t);
    return false;
  }
  vec2 origin = texelFetch(border_uv, list_place(edge), 0).xy * float(buffer_size);
  mat2 linear = mat2(matrix.xy, matrix.zw);
  vec2 crossing = mix(walk.from, walk.to, t);
  vec2 goal = image.xy * float(buffer_size);
  walk.from = linear * (crossing - origin) + goal;
  walk.to = linear * (walk.to - origin) + goal;
  walk.origin = linear * (walk.origin - origin) + goal;
  walk.linear = linear * walk.linear;
  walk.chart = int(image.w);
  ++walk.jumps;
  return true;
}

void march(inout Walk walk) {
  int came_from = -1;
  float t = 0.0;
  walk.outcome = FOUND;
  for (int count = 0; count < MAX_MARCH_STEPS; ++count) {
    vec2 way = walk.to - walk.from;
    float span = max(length(way), 1e-6);
    vec2 place = walk.from + way * t;
    ivec2 texel = clamp(ivec2(floor(place)), ivec2(0), ivec2(buffer_size - 1));
    ivec2 cell = texelFetch(border, texel, 0).xy;
    if (cell.x > 0) {
      t += float(cell.x) / span;
      if (t >= 1.0) return;
      continue;
    }
    // To the texel's far side, and a little beyond so that rounding cannot hold the walk here.
    vec2 sides = vec2(texel) + step(vec2(0.0), way) - place;
    vec2 ways = vec2(abs(way.x) > 1e-12 ? sides.x / way.x : 1e9, abs(way.y) > 1e-12 ? sides.y / way.y : 1e9);
    float leave = t + max(min(ways.x, ways.y), 0.0) + 1e-3 / span;
    if (cell.x < 0) {
      int edge = first_exit(cell, walk, came_from, min(leave, 1.0), t);
      if (edge >= 0) {
        if (walk.jumps == MOST_JUMPS) {
          walk.outcome = texelFetch(links, list_place(2 * edge + 1), 0).z == -2.0 ? BOUNDARY : LOST;
          return;
        }
        if (!jump(walk, edge, t, came_from)) return;
#if PAPER
        mark(walk, edge);
#endif
        t = 0.0;
        continue;
      }
    }
    t = leave;
    if (t >= 1.0) return;
  }
  walk.outcome = LOST;
}

// The texel of this chart nearest to a place on it; its own, or one beside it where another chart owns that.
bool find_texel(vec2 place, int chart, out ivec2 texel) {
  texel = clamp(ivec2(floor(place)), ivec2(0), ivec2(buffer_size - 1));
  if (texelFetch(ids, texel, 0).x == chart) return true;
  float nearest = 1e9;
  ivec2 own = texel;
  for (int i = 0; i < 9; ++i) {
    ivec2 beside = own + ivec2(i % 3 - 1, i / 3 - 1);
    if (any(lessThan(beside, ivec2(0))) || any(greaterThanEqual(beside, ivec2(buffer_size)))) continue;
    vec2 gap = vec2(beside) + 0.5 - place;
    float distance = dot(gap, gap);
    if (distance >= nearest || texelFetch(ids, beside, 0).x != chart) continue;
    nearest = distance;
    texel = beside;
  }
  return nearest < 1e9;
}
