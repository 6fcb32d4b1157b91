// The centers of one dispatch that follow links, and the lists of near cells whose neighbors they need, each listed once.
layout(std430, binding = BINDING_WALKS) restrict buffer Walks { int walks[]; };
layout(location = LOCATION_LISTS) uniform int list_count;

// The parts of walks: a flag per list whether it was asked for, then the lists and the centers of this dispatch.
int walks_of_list(int list) { return WALKS_HEADER + list; }
int walks_list(int i) { return WALKS_HEADER + list_count + i; }
int walks_center(int i) { return WALKS_HEADER + 2 * list_count + i; }
