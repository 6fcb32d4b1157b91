// The cells near the start cells of centers, in sorted lists.
layout(binding = UNIT_NEAR_CELLS) uniform isamplerBuffer near_list;

// The index of a cell in one list, or -1.
int place_of(int cell, ivec2 range) {
  int low = range.x, high = range.y;
  while (low < high) {
    int middle = (low + high) / 2;
    bool below = texelFetch(near_list, middle).x < cell;
    low = below ? middle + 1 : low;
    high = below ? high : middle;
  }
  return low < range.y && texelFetch(near_list, low).x == cell ? low - range.x : -1;
}
