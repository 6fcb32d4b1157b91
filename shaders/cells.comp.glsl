#version 450 core
// One invocation, one cell → the area element by which it is sampled: its largest, four times that where a border cuts the cell. A square
// there lies on the chart or not by its one sample, so squares are half as wide.
#include "buffers.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_AREAS) writeonly restrict buffer Areas { float areas[]; };
layout(binding = UNIT_LABELS) uniform isampler2D labels;
layout(binding = UNIT_BOXES) uniform isampler2D boxes;
layout(location = 2) uniform int first;
layout(location = 3) uniform int last;
layout(location = 8) uniform int block_size;

void main() {
  int cell = first + int(gl_GlobalInvocationID.x);
  if (cell >= last) return;
  ivec4 box = texelFetch(boxes, list_place(cell), 0);
  float largest = 0.0;
  float inside = 0.0;
  for (int i = 0; i < box.z * box.w; ++i) {
    ivec2 texel = box.xy + ivec2(i % box.z, i / box.z);
    ivec2 label = texelFetch(labels, texel, 0).xy;
    if (label.x != cell) continue;
    largest = max(largest, area_element_at(texel));
    inside += float(label.y) / 65536.0;
  }
  bool whole = inside > float(block_size * block_size) - 0.5;
  areas[cell] = whole ? largest : 4.0 * largest;
}
