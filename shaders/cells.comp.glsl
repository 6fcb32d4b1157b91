#version 450 core
// One invocation, one cell → where it lies, which way it faces, and the area element by which it is sampled: its largest, four times that
// where a border cuts the cell. A square there lies on the chart or not by its one sample, so squares are half as wide.
#include "variant.glsl"
#include "buffers.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CELLS) writeonly restrict buffer CellList { CellData cells[]; };
layout(binding = UNIT_LABELS) uniform isampler2D labels;
layout(binding = UNIT_BOXES) uniform isampler2D boxes;
layout(location = 2) uniform int first;
layout(location = 3) uniform int last;
layout(location = 8) uniform int block_size;

void main() {
  int cell = first + int(gl_GlobalInvocationID.x);
  if (cell >= last) return;
  ivec4 box = texelFetch(boxes, list_place(cell), 0);
  vec3 low = vec3(1e30), high = vec3(-1e30), face = vec3(0.0);
  float largest = 0.0, inside = 0.0, area = 0.0, cosine = 1.0;
  for (int y = 0; y < box.w; ++y)
    for (int x = 0; x < box.z; ++x) {
      ivec2 texel = box.xy + ivec2(x, y);
      ivec2 label = texelFetch(labels, texel, 0).xy;
      vec3 normal;
      vec4 point = surface_at(texel, normal);
      if (label.x != cell) continue;
      low = min(low, point.xyz);
      high = max(high, point.xyz);
      if (largest == 0.0) face = normal;
      cosine = min(cosine, dot(face, normal));
      largest = max(largest, max(point.w, 1e-30));
      inside += float(label.y) / 65536.0;
      area += point.w * float(label.y) / 65536.0;
    }
  bool whole = inside > float(block_size * block_size) - 0.5;
  float size = float(buffer_size);
  vec4 sphere = largest > 0.0 ? vec4(0.5 * (low + high), 0.5 * length(high - low)) : vec4(0.0, 0.0, 0.0, -1.0);
  cells[cell] = CellData(sphere, vec4(face, cosine),
                         vec4(whole ? largest : 4.0 * largest, area / (size * size), 0.0, 0.0));
}
