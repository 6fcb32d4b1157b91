// The state of ambiguous centers in one list: the ambiguous centers; the centers that are computed again; and for each of these a
// hash table of its flood's patches, by open addressing. An entry has two numbers: patch (-1: none), and bits of its triangles.
layout(std430, binding = BINDING_CONNECTED) restrict buffer Connected { int connected[]; };

int ambiguous_center(int i) { return CONNECTED_HEADER + i; }
int center_again(int i) { return CONNECTED_HEADER + params.total + i; }
int table_again(int i) { return CONNECTED_HEADER + params.total + params.slots + 2 * params.flood_table * i; }

// The first place to look for a patch in a table, whose size is a power of two.
int first_place(int patch_number, int size) {
  uint bits = uint(patch_number) * 0x9E3779B1u; // 2^32 over the golden ratio
  return int((bits ^ bits >> 15) & uint(size - 1));
}

// Returns whether the flood of the i-th center that is computed again reached the triangle of this code.
bool was_reached(int i, int code) {
  int patch_number = code / PATCH_TRIANGLES, table = table_again(i), place = first_place(patch_number, params.flood_table);
  for (int found = connected[table + 2 * place]; code >= 0 && found >= 0; found = connected[table + 2 * place]) {
    if (found == patch_number) return (uint(connected[table + 2 * place + 1]) >> (code & PATCH_TRIANGLES - 1) & 1u) != 0u;
    place = place + 1 & params.flood_table - 1;
  }
  return false;
}
