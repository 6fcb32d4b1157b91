// The cells of the neighborhood → its samples: one texel of every so many, the same ones for every center.
#include "buffers.glsl"
layout(std430, binding = BINDING_SUPPORTS) readonly restrict buffer Supports { SupportData supports[]; };
layout(std430, binding = BINDING_CELLS) readonly restrict buffer SupportCells { int support_cells[]; };
layout(std430, binding = BINDING_AREAS) readonly restrict buffer Areas { float areas[]; };
layout(std430, binding = BINDING_BARE_BEGIN) readonly restrict buffer BareBegin { int bare_begin[]; };
layout(std430, binding = BINDING_BARE) readonly restrict buffer Bare { vec4 bare[]; };
layout(binding = UNIT_LABELS) uniform isampler2D labels;
layout(binding = UNIT_BOXES) uniform isampler2D boxes;

// A place in [0, 2^16)^2 that depends on the grid's square and the seed alone: every center takes the same texel of it.
ivec2 jitter(ivec2 square) {
  uint h = uint(square.x) * 0x8da6b343u ^ uint(square.y) * 0xd8163841u ^ uint(seed) * 0xcb1ab31fu;
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  h ^= h >> 16;
  return ivec2(h & 0xffffu, h >> 16);
}

// Texels between the samples of a cell: a power of two, so that blocks hold whole squares, and so few that no square has more area than one
// of `samples` equal parts of the enlarged disk.
int stride_of(float largest_area_element) {
  float texel_area = max(largest_area_element, 1e-30) / (float(buffer_size) * float(buffer_size));
  float share = PI * enlargement * enlargement * radius * radius / float(samples);
  return clamp(1 << int(floor(clamp(0.5 * log2(share / texel_area), 0.0, 16.0))), 1, block_size);
}

#if ADAPTIVE
// The black squares of a chessboard first, and the white ones then.
#define IS_TAKEN(square) (((square.x ^ square.y) & 1) == part)
#define BARE_SHARE 0.5 // in either part
void sample_support(inout Sums sums, CenterData data, int index, int part) {
#else
#define IS_TAKEN(square) true
#define BARE_SHARE 1.0
void sample_support(inout Sums sums, CenterData data, int index) {
  const int part = 0;
#endif
  SupportData support = supports[index];
  sums.moments.cut = support.cut;
  float size = float(buffer_size);
  int iterations = 0;
  int j = support.first, end = support.first + support.count;
  // One loop over the squares of all cells: nested ones would run, for the invocations that a device runs side by side, as often as
  // the longest of each cell in turn, and so end early where cells are sampled in different steps.
  int i = 0, squares = 0, total = 0, cell = 0, stride = 1, width = 1, bare_first = 0;
  ivec2 first_square = ivec2(0); // squares are those of a grid over the whole buffer
  float area = 0.0;
  for (;;) {
    if (i == total) {
      if (j == end) break;
      int entry = support_cells[j++];
      cell = entry < 0 ? -1 - entry : entry;
      float largest = areas[cell] * (entry < 0 ? 16.0 : 1.0);
      ivec4 box = texelFetch(boxes, list_place(cell), 0);
      stride = stride_of(largest);
      first_square = box.xy / stride;
      ivec2 last_square = (box.xy + box.zw - 1) / stride;
      width = last_square.x - first_square.x + 1;
      bare_first = bare_begin[cell];
      squares = width * (last_square.y - first_square.y + 1);
      total = squares + bare_begin[cell + 1] - bare_first;
      i = 0;
      area = float(stride * stride) / (size * size);
      iterations += 1 + total;
      if (iterations > MAX_ITERATIONS) {
        sums.moments.lost += largest * float(block_size * block_size) / (size * size);
        total = 0;
      }
      continue;
    }
    if (i < squares) {
      ivec2 square = first_square + ivec2(i % width, i / width);
      ivec2 low = square * stride;
      ivec2 texel = low + (jitter(low) & (stride - 1));
      if (IS_TAKEN(square) && all(lessThan(texel, ivec2(buffer_size)))) {
        ivec2 label = texelFetch(labels, texel, 0).xy;
        if (label.x == cell) add_texel(sums, texel, area * float(label.y) / 65536.0, -1.0);
      }
    } else {
      int k = bare_first + i - squares;
      vec4 point = bare[2 * k];
      vec3 offset = point.xyz - sums.center.position;
      int triangle = int(bare[2 * k + 1].w);
      if (is_reached(triangle))
        add_neighbor(sums, point.xyz, bare[2 * k + 1].xyz, triangle, BARE_SHARE * point.w, dot(offset, offset) < point.w, -1.0, MAP_OF_BARE(k));
    }
    ++i;
  }
}
