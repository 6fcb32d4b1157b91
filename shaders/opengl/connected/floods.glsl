// What is kept of ambiguous centers, in one list: the ambiguous centers; those that are computed again; and for each of these a table of
// the patches that its flood came to, open addresses with two numbers each: patch (-1: none), and the bits of its triangles.
layout(std430, binding = BINDING_CONNECTED) restrict buffer Connected { int connected[]; };

int ambiguous_center(int i) { return CONNECTED_HEADER + i; }
int center_again(int i) { return CONNECTED_HEADER + params.total + i; }
int table_again(int i) { return CONNECTED_HEADER + params.total + params.slots + 2 * params.flood_table * i; }

// Where a patch's search in a table begins, whose size is a power of two.
int first_place(int patch_number, int size) {
  uint bits = uint(patch_number) * 0x9E3779B1u; // 2^32 over the golden ratio
  return int((bits ^ bits >> 15) & uint(size - 1));
}

// Whether the flood of the i-th of them reached the triangle of a code.
bool was_reached(int i, int code) {
  int patch_number = code / PATCH_TRIANGLES, table = table_again(i), place = first_place(patch_number, params.flood_table);
  for (int found = connected[table + 2 * place]; code >= 0 && found >= 0; found = connected[table + 2 * place]) {
    if (found == patch_number) return (uint(connected[table + 2 * place + 1]) >> (code & PATCH_TRIANGLES - 1) & 1u) != 0u;
    place = place + 1 & params.flood_table - 1;
  }
  return false;
}
