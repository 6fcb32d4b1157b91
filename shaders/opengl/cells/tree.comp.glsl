#version 450 core
// One invocation per node of the tree of cells → the box around its children, which are on the level below.
#include "opengl/elements.glsl"
#include "opengl/cells/search.glsl"
#include "opengl/cells/tree.glsl"
layout(std430, binding = BINDING_CELL_NODES) restrict buffer Nodes { ivec4 nodes[]; };
layout(location = LOCATION_LEVEL) uniform int level;

void main() {
  int i = own_element();
  if (i >= last) return;
  int node = node_at(level, i), after = node_after(level, i);
  vec3 low = vec3(1e30), high = vec3(-1e30);
  for (int within = node + 1; within < after; within = nodes[2 * within].w) {
    low = min(low, intBitsToFloat(nodes[2 * within].xyz));
    high = max(high, intBitsToFloat(nodes[2 * within + 1].xyz));
  }
  nodes[2 * node] = ivec4(floatBitsToInt(low), after);
  nodes[2 * node + 1] = ivec4(floatBitsToInt(high), -1);
}
