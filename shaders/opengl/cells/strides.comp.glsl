#version 450 core
// One invocation per cell → the values that depend on the radius: its bounds including texelless triangles at it, how finely its
// leaves are sampled, and where their samples are stored.
//
// A sample stands for at most its share of a disk's area. Where the surface bends, a fine sample, near a center, stands for at
// most an eighth of that.
#include "variant.glsl"
#include "opengl/elements.glsl"
#include "opengl/cells/search.glsl"
#include "opengl/cells/samples.glsl"
#include "opengl/cells/tree.glsl"
layout(std430, binding = BINDING_CELLS) readonly restrict buffer CellList { CellData cells[]; };
layout(std430, binding = BINDING_CELL_TRAITS) writeonly restrict buffer Traits { ivec4 traits[]; };
layout(std430, binding = BINDING_CELL_NODES) writeonly restrict buffer Nodes { ivec4 nodes[]; };
layout(std430, binding = BINDING_STRIDES) writeonly restrict buffer Strides { ivec2 strides[]; };
layout(std430, binding = BINDING_LEAF_LISTS) writeonly restrict buffer LeafLists { ivec4 leaf_lists[]; };
layout(binding = UNIT_CELL_LISTS) uniform isamplerBuffer cell_lists;
#if TEXELLESS
layout(std430, binding = BINDING_TEXELLESS) readonly restrict buffer Texelless { TexellessSample texelless[]; };
layout(binding = UNIT_TEXELLESS_RANGES) uniform isamplerBuffer texelless_ranges;
#endif

const int finer = 3;           // doublings
const float even = 0.9;        // cosine between the normals of a leaf without detail
const float anywhere = 1e30;   // bound for a cell without points, which may lead anywhere

void enclose_texelless_samples(int cell, inout vec4 sphere, inout vec4 cone) {
#if TEXELLESS
  ivec2 range = texelFetch(texelless_ranges, cell).xy;
  for (int i = range.x; i < range.y; ++i) {
    TexellessSample one = texelless[i];
    if (sphere.w < 0.0) {
      sphere = vec4(one.position, 0.0);
      cone = vec4(one.normal, 1.0);
    }
    sphere.w = max(sphere.w, length(one.position - sphere.xyz));
    cone.w = min(cone.w, dot(cone.xyz, one.normal));
  }
#endif
}

// The exponent of the largest power of two up to a number, clamped to [0, most].
int doublings_to(float number, int most) { return clamp((floatBitsToInt(number) >> 23 & 255) - 127, 0, most); }

// Doublings of each leaf by itself, and whether the four leaves are joined into one list.
struct Doublings {
  int coarse[CELL_LEAVES], fine[CELL_LEAVES];
  bool joined;
};

Doublings choose_doublings(int cell, bool at_boundary) {
  // At the mesh's own boundary no other chart makes up for what texels miss.
  float wanted = at_boundary ? 0.25 * search.share : search.share;
  Doublings found;
  float largest = 0.0;
  int detailed = 0, all = 0;
  for (int i = 0; i < CELL_LEAVES; ++i) {
    LeafData leaf = cells[cell].leaf[i];
    if (leaf.sphere.w < 0.0) continue;
    ++all;
    if (leaf.area.y < even) detailed |= 1 << i;
    largest = max(largest, leaf.area.x);
  }
  int most = most_doublings(), together = doublings_to(wanted / largest, 2 * findMSB(search.block_size));
  found.joined = together > most && all == CELL_LEAVES && (detailed == 0 || bitCount(uint(detailed)) == all);
  for (int i = 0; i < CELL_LEAVES; ++i) {
    float area = cells[cell].leaf[i].area.x;
    int own = doublings_to(wanted / area, most);
    found.coarse[i] = found.joined ? together : own;
    found.fine[i] = found.coarse[i];
    if ((detailed >> i & 1) != 0) found.fine[i] = doublings_to(wanted / (area * float(1 << finer)), most);
  }
  return found;
}

// The number of samples of each half of a leaf.
ivec2 count_samples(int cell, Squares squares) {
  ivec2 halves = ivec2(0), unused;
  for (int y = squares.low.y; y < squares.end.y; ++y)
    for (int x = squares.low.x; x < squares.end.x; ++x) {
      int at = half_of(cell, squares, ivec2(x, y), unused);
      if (at == 0) ++halves.x;
      if (at == 1) ++halves.y;
    }
  return halves;
}

// Packs sizes in 16 bits each.
ivec2 in_pairs(ivec4 sizes) { return sizes.xz | sizes.yw << 16; }
int sum(ivec4 sizes) { return sizes.x + sizes.y + sizes.z + sizes.w; }

void list_leaves(int cell, ivec4 coarse, ivec4 coarse_halves, ivec4 fine, ivec4 fine_halves) {
  int first = atomicAdd(counts.samples, sum(coarse) + sum(fine)), first_fine = first + sum(coarse);
  leaf_lists[LEAF_LISTS * cell] = ivec4(first, in_pairs(coarse), 0);
  leaf_lists[LEAF_LISTS * cell + 1] = ivec4(first, in_pairs(coarse_halves), 0);
  leaf_lists[LEAF_LISTS * cell + 2] = ivec4(first_fine, in_pairs(fine), 0);
  leaf_lists[LEAF_LISTS * cell + 3] = ivec4(first_fine, in_pairs(fine_halves), 0);
}

void main() {
  int cell = own_element();
  if (cell >= last) return;
  vec4 sphere = cells[cell].sphere, cone = cells[cell].cone, area = cells[cell].area;
  enclose_texelless_samples(cell, sphere, cone);
  ivec2 boundary = texelFetch(cell_lists, cell).zw;
  bool at_boundary = boundary.x < boundary.y;
  Doublings doublings = choose_doublings(cell, at_boundary);
  ivec4 box = texelFetch(boxes, list_texel(cell), 0), coarse, coarse_halves, fine, fine_halves;
  ivec2 codes = ivec2(0);
  int bits = (doublings.joined ? CELL_JOINED : 0) | (at_boundary ? CELL_AT_BOUNDARY : 0);
  for (int i = 0; i < CELL_LEAVES; ++i) {
    codes |= ivec2(doublings.coarse[i], doublings.fine[i]) << 8 * i;
    ivec2 halves = count_samples(cell, squares_of(box, i, doublings.coarse[i]));
    coarse[i] = halves.x + halves.y;
    coarse_halves[i] = halves.x;
    halves = ivec2(0);
    if (doublings.fine[i] != doublings.coarse[i]) { // fine samples are listed only if they differ from the coarse ones
      halves = count_samples(cell, squares_of(box, i, doublings.fine[i]));
      if (cells[cell].leaf[i].sphere.w >= 0.0) bits |= CELL_FINE_LEAF << i;
    }
    fine[i] = halves.x + halves.y;
    fine_halves[i] = halves.x;
  }
  list_leaves(cell, coarse, coarse_halves, fine, fine_halves);
  if (bits >= CELL_FINE_LEAF) counts.fine = 1;
  strides[cell] = codes;
  traits[CELL_TRAITS * cell] = floatBitsToInt(sphere);
  traits[CELL_TRAITS * cell + 1] = floatBitsToInt(cone);
  traits[CELL_TRAITS * cell + 2] = ivec4(floatBitsToInt(area.xy), bits, 0);
  float reach = sphere.w < 0.0 ? anywhere : LINK_REACH * sphere.w;
  int node = node_at(0, cell);
  nodes[2 * node] = ivec4(floatBitsToInt(sphere.xyz - reach), node + 1);
  nodes[2 * node + 1] = ivec4(floatBitsToInt(sphere.xyz + reach), cell);
}
