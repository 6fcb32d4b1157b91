#version 450 core
// One invocation per center → its neighborhood: samples of the surface connected to it within the ball, as ranges of lists.
//
// The cells near its start cell were found for all centers there. If those in the center's own ball form a single sheet that
// faces the center's way and does not fold back, they are its neighborhood. Otherwise, and at the mesh's boundary, another
// dispatch (OVER_LINKS) follows links within the center's own ball from cell to cell; it groups the centers that need this.
#include "variant.glsl"
#include "device.glsl"
#include "opengl/evaluate/params.glsl"
#include "opengl/cells/search.glsl"
#include "opengl/cells/near_cells.glsl"
#include "opengl/cells/walks.glsl"
#if OVER_LINKS
#include "opengl/cells/connected_cells.glsl"
#endif
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
#if EXACT
#include "opengl/connected/floods.glsl"
#endif
layout(std430, binding = BINDING_NEIGHBORHOODS) writeonly restrict buffer Neighborhoods { NeighborhoodRanges neighborhoods[]; };
layout(std430, binding = BINDING_RANGES) writeonly restrict buffer Ranges { ivec2 ranges[]; };
layout(binding = UNIT_CELLS) uniform samplerBuffer cells;
layout(binding = UNIT_LEAF_LISTS) uniform isamplerBuffer leaf_lists;
layout(binding = UNIT_NEAR_RANGES) uniform isamplerBuffer near_ranges;
#if TEXELLESS
layout(binding = UNIT_TEXELLESS_RANGES) uniform isamplerBuffer texelless_ranges;
#endif

// The leaves of a cell that a center takes.
struct Taken {
  int leaves, fine; // one bit per leaf
};
const int all_leaves = (1 << CELL_LEAVES) - 1;
const float near_share = 0.25; // of the radius: nearer leaves have more samples, because their finer detail counts

// The list being written: the index of its next range, and the open range, to which adjacent ranges are appended.
struct List {
  int next;
  ivec2 open;
};

void append(inout List list, ivec2 range) {
  if (range.x >= range.y) return;
  if (range.x == list.open.y) {
    list.open.y = range.y;
    return;
  }
  if (list.open.x < list.open.y) ranges[list.next++] = list.open;
  list.open = range;
}

// Closes a list. Returns where the next one begins.
int end_of(inout List list) {
  if (list.open.x < list.open.y) ranges[list.next++] = list.open;
  list.open = ivec2(-1);
  return list.next;
}

Taken take(NearTraits cell, int entry, vec3 center) {
  Taken all = Taken(all_leaves, 0), some = Taken(0, 0);
  NearSphere from = near_sphere(entry, center);
  bool joined = (cell.bits & CELL_JOINED) != 0, whole = joined || within_ball(from);
#if FINE
  float within = near_share * params.radius + 2.0 * from.sphere.w;
  bool near = cell.bits >= CELL_FINE_LEAF && from.square < within * within;
#else
  const bool near = false;
#endif
  if (whole && !near) return all;
  ivec4 codes = texelFetch(near_traits, NEAR_TRAITS * entry + 1);
  for (int i = 0; i < CELL_LEAVES; ++i) {
    int code = codes[i];
    vec3 offset = vec3(code & 255, code >> 8 & 255, code >> 16 & 255) * (2.0 / 255.0) - 1.0;
    vec3 gap = from.sphere.xyz + offset * cell.unit - center;
    float own = float(code >> 24 & 255) * (cell.unit / LEAF_RADII);
    float square = dot(gap, gap), outer = params.radius + own, inner = near_share * params.radius + own;
    if (code != -1 && square < outer * outer) some.leaves |= 1 << i;
    if (code != -1 && near && (cell.bits & CELL_FINE_LEAF << i) != 0 && square < inner * inner) some.fine |= 1 << i;
  }
  if (!joined) return some;
  return some.fine != 0 ? Taken(some.leaves, all_leaves) : all; // its samples include those of all leaves
}

// Ranges of the samples of a cell's leaves, or of one half of them: the begins and ends of four lists.
struct LeafLists {
  ivec4 begin, end;
  int size; // samples in both halves of all leaves
};

ivec4 sizes_of(ivec4 list) { return ivec4(list.y & 65535, list.y >> 16 & 65535, list.z & 65535, list.z >> 16 & 65535); }

// The squares whose samples are listed in one turn.
#define BLACK_SQUARES 0
#define WHITE_SQUARES 1
#define ALL_SQUARES 2

// kind: 0 coarse, 1 fine.
LeafLists lists_of(int cell, int kind, int turn) {
  ivec4 list = texelFetch(leaf_lists, LEAF_LISTS * cell + 2 * kind), sizes = sizes_of(list);
  ivec4 begin = list.x + ivec4(0, sizes.x, sizes.x + sizes.y, sizes.x + sizes.y + sizes.z), end = begin + sizes;
  int size = end.w - begin.x;
#if ADAPTIVE
  ivec4 middle = begin + sizes_of(texelFetch(leaf_lists, LEAF_LISTS * cell + 2 * kind + 1));
  if (turn == BLACK_SQUARES) return LeafLists(begin, middle, size);
  if (turn == WHITE_SQUARES) return LeafLists(middle, end, size);
#endif
  return LeafLists(begin, end, size);
}

void append_samples(inout List list, Taken taken, LeafLists coarse, LeafLists fine) {
  for (int i = 0; i < CELL_LEAVES; ++i) {
    bool is_fine = (taken.fine >> i & 1) != 0;
    if ((taken.leaves >> i & 1) != 0)
      append(list, is_fine ? ivec2(fine.begin[i], fine.end[i]) : ivec2(coarse.begin[i], coarse.end[i]));
  }
}

// Finds the next taken cell. word: -1 at first, NEAR_WORDS at the end. left: the remaining bits of this word.
int next_taken(inout int word, inout uint left) {
  while (left == 0u && ++word < NEAR_WORDS) left = taken[word];
  int k = 32 * word + findLSB(left);
  left &= left - 1u;
  return k;
}

// The most samples of one center. A center that is computed again looks up each sample's triangle, and these rounds count as
// well.
#if EXACT
#define MOST_SAMPLES (MAX_ITERATIONS / 4)
#else
#define MOST_SAMPLES MAX_ITERATIONS
#endif

// Appends samples on texels. Leaves out samples beyond a device's iterations, and returns their area.
float list_samples(inout List list, vec3 center, ivec2 near_cells, int turn) {
  float missing_area = 0.0;
  int total = 0, word = -1;
  uint left = 0u;
  for (;;) {
    int k = next_taken(word, left);
    if (word == NEAR_WORDS) break;
    NearTraits cell = near_traits_of(near_cells.x + k);
    Taken some = take(cell, near_cells.x + k, center);
    LeafLists coarse = lists_of(cell.number, 0, turn), fine = coarse;
    total += 1 + coarse.size;
#if FINE
    fine = lists_of(cell.number, 1, turn);
    if (some.fine != 0) total += fine.size;
#endif
#if TEXELLESS
    ivec2 texelless = texelFetch(texelless_ranges, cell.number).xy;
    total += texelless.y - texelless.x;
#endif
    if (total > MOST_SAMPLES) {
      taken[word] &= ~(1u << (k & 31));
      missing_area += texelFetch(cells, CELL_VECTORS * cell.number + 2).x;
    } else {
      append_samples(list, some, coarse, fine);
    }
  }
  return missing_area;
}

// Appends the samples of triangles without texels.
void list_texelless_samples(inout List list, ivec2 near_cells) {
#if TEXELLESS
  int word = -1;
  uint left = 0u;
  for (;;) {
    int k = next_taken(word, left);
    if (word == NEAR_WORDS) break;
    int cell = texelFetch(near_traits, NEAR_TRAITS * (near_cells.x + k)).x;
    append(list, texelFetch(texelless_ranges, cell).xy);
  }
#endif
}

// Appends a center to the list of centers that follow links, and its list of near cells to the lists that these centers need.
void ask_for_links(int slot, int list) {
  int i = atomicAdd(walks[WALKS_CENTERS], 1);
  walks[walks_center(i)] = slot;
  atomicMax(walks[WALKS_CENTERS_GROUPS], i / GROUP_SIZE + 1);
  if (atomicExchange(walks[walks_of_list(list)], 1) != 0) return;
  i = atomicAdd(walks[WALKS_LISTS], 1);
  walks[walks_list(i)] = list;
  atomicMax(walks[WALKS_LISTS_GROUPS], min(i + 1, 65535));
}

void list_neighborhood(int slot, vec3 center, ivec2 near_cells, bool single, bool boundary) {
  NeighborhoodRanges found;
  List list = List(slot * ranges_of_center, ivec2(-1));
  found.first = list.next;
#if ADAPTIVE
  found.missing_area = list_samples(list, center, near_cells, BLACK_SQUARES);
  found.middle = end_of(list);
  list_samples(list, center, near_cells, WHITE_SQUARES);
  found.last = end_of(list);
#else
  found.missing_area = list_samples(list, center, near_cells, ALL_SQUARES);
  found.middle = found.last = end_of(list);
#endif
  list_texelless_samples(list, near_cells);
  found.end = end_of(list);
  found.hits_boundary = boundary ? 1.0 : 0.0;
  found.single_sheet = single ? 1 : 0;
  neighborhoods[slot] = found;
}

void main() {
  int slot = int(gl_GlobalInvocationID.x);
#if OVER_LINKS
  if (slot >= walks[WALKS_CENTERS]) return;
  slot = walks[walks_center(slot)];
#endif
  int index = params.first + slot;
  if (index >= params.last) return;
#if EXACT
  if (slot >= connected[CONNECTED_AGAIN]) return;
  index = connected[center_again(slot)];
#endif
  vec3 center = centers[index].position;
  ivec2 starts = texelFetch(start_ranges, index).xy;
  ivec4 list = ivec4(0);
  if (starts.x < starts.y && lists_fit()) list = texelFetch(near_ranges, texelFetch(start_cells, starts.x).y);
  ivec2 near_cells = list.xy;
  bool single = take_near_cells(center, near_cells, list.w <= 1), boundary = false;
#if OVER_LINKS
  keep_connected(center, starts, near_cells);
  boundary = boundary_meets(center, near_cells);
#else
  if (!single && near_cells.x < near_cells.y) {
    ask_for_links(slot, texelFetch(near_traits, NEAR_TRAITS * near_cells.x + 2).z);
    return;
  }
#endif
  list_neighborhood(slot, center, near_cells, single, boundary);
}
