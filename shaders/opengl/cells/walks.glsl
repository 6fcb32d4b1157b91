// The centers of one dispatch that go over links, and the lists of near cells whose neighbors they need: a list is named by the cell in
// which its centers start, and made once.
layout(std430, binding = BINDING_WALKS) restrict buffer Walks { int walks[]; };
layout(location = LOCATION_CELLS) uniform int cell_count;

// Where its parts begin: whether the list of a cell was asked for, and the lists and centers of this dispatch.
int walks_of_cell(int cell) { return WALKS_HEADER + cell; }
int walks_list(int i) { return WALKS_HEADER + cell_count + i; }
int walks_center(int i) { return WALKS_HEADER + 2 * cell_count + i; }
