#version 450 core
// One invocation per cell → the samples of its leaves, in the lists that strides.comp.glsl made room for.
#include "opengl/elements.glsl"
#include "opengl/cells/search.glsl"
#include "opengl/cells/samples.glsl"
layout(std430, binding = BINDING_SAMPLES) writeonly restrict buffer Samples { ivec2 samples[]; };
layout(binding = UNIT_STRIDES) uniform isamplerBuffer strides;
layout(binding = UNIT_LEAF_LISTS) uniform isamplerBuffer leaf_lists;

int size_of_leaf(ivec4 list, int leaf) { return list[1 + leaf / 2] >> 16 * (leaf & 1) & 65535; }

void main() {
  int cell = own_element();
  if (cell >= last || counts.samples > search.room.samples) return;
  ivec4 box = texelFetch(boxes, list_texel(cell), 0);
  ivec2 codes = texelFetch(strides, cell).xy;
  for (int kind = 0; kind < 2; ++kind) { // coarse, fine
    ivec4 all = texelFetch(leaf_lists, LEAF_LISTS * cell + 2 * kind), halves = texelFetch(leaf_lists, LEAF_LISTS * cell + 2 * kind + 1);
    int first = all.x;
    for (int leaf = 0; leaf < CELL_LEAVES; ++leaf) {
      int size = size_of_leaf(all, leaf);
      if (size == 0) continue;
      ivec2 next = ivec2(first, first + size_of_leaf(halves, leaf)), entry;
      Squares squares = squares_of(box, leaf, of_leaf(codes[kind], leaf));
      for (int y = squares.low.y; y < squares.end.y; ++y)
        for (int x = squares.low.x; x < squares.end.x; ++x) {
          int at = half_of(cell, squares, ivec2(x, y), entry);
          if (at < 0) continue;
          samples[at == 0 ? next.x++ : next.y++] = entry;
        }
      first += size;
    }
  }
}
