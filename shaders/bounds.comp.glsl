#version 450 core
// One invocation, one cell → the box around its surface points, and its largest area element.
#include "buffers.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_BOUNDS) writeonly restrict buffer Bounds { vec4 bounds[]; };
layout(binding = UNIT_LABELS) uniform isampler2D labels;
layout(binding = UNIT_CORNERS) uniform isampler2D corners;
layout(location = 3) uniform int last;
layout(location = 8) uniform int block_size;

void main() {
  int cell = int(gl_GlobalInvocationID.x);
  if (cell >= last) return;
  ivec2 corner = texelFetch(corners, list_place(cell), 0).xy;
  vec4 low = vec4(1e30, 1e30, 1e30, 0.0), high = vec4(-1e30);
  for (int i = 0; i < block_size * block_size; ++i) {
    ivec2 texel = min(corner + ivec2(i % block_size, i / block_size), ivec2(buffer_size - 1));
    if (texelFetch(labels, texel, 0).x != cell) continue;
    vec4 point = texelFetch(positions, texel, 0);
    low = vec4(min(low.xyz, point.xyz), max(low.w, point.w));
    high = max(high, point);
  }
  bounds[2 * cell] = low;
  bounds[2 * cell + 1] = high;
}
