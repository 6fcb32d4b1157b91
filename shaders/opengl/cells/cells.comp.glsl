#version 450 core
// One invocation per cell → spheres and normal cones of the cell and its leaves, and the area element by which a leaf is sampled:
// its largest, or four times that if a border cuts the leaf. There one sample decides whether a square lies on the chart, so
// squares are half as wide.
#include "variant.glsl"
#include "opengl/evaluate/buffers.glsl"
#include "opengl/elements.glsl"
layout(std430, binding = BINDING_CELLS) writeonly restrict buffer CellList { CellData cells[]; };
layout(binding = UNIT_LABELS) uniform isampler2D labels;
layout(binding = UNIT_BOXES) uniform isampler2D boxes;
layout(location = LOCATION_BLOCK_SIZE) uniform int block_size;

vec4 sphere_around(vec3 low, vec3 high) {
  return low.x <= high.x ? vec4(0.5 * (low + high), 0.5 * length(high - low)) : vec4(0.0, 0.0, 0.0, -1.0);
}

// Encodes the sphere of a leaf in 8 bits each for its offset from the cell's middle and its radius, in units of the cell's
// radius. The rounded sphere encloses the exact one.
int code_of(vec4 leaf, vec4 cell) {
  if (leaf.w < 0.0) return -1;
  float unit = max(cell.w, 1e-30);
  ivec3 offset = ivec3(round(clamp(0.5 + 0.5 * (leaf.xyz - cell.xyz) / unit, 0.0, 1.0) * 255.0));
  int radius = int(min(ceil((leaf.w / unit + 0.007) * LEAF_RADII), 254.0));
  return offset.x | offset.y << 8 | offset.z << 16 | radius << 24;
}

void main() {
  int cell = own_element();
  if (cell >= last) return;
  ivec4 box = texelFetch(boxes, list_texel(cell), 0);
  int side = block_size / 2;
  vec3 low = vec3(1e30), high = vec3(-1e30), face = vec3(0.0);
  float area = 0.0, cosine = 1.0;
  vec4 spheres[CELL_LEAVES];
  for (int leaf = 0; leaf < CELL_LEAVES; ++leaf) {
    ivec2 corner = box.xy / block_size * block_size + side * ivec2(leaf & 1, leaf >> 1);
    ivec2 begin = max(box.xy, corner), end = min(box.xy + box.zw, corner + side);
    vec3 leaf_low = vec3(1e30), leaf_high = vec3(-1e30), leaf_face = vec3(0.0);
    float largest = 0.0, inside = 0.0, leaf_cosine = 1.0;
    for (int y = begin.y; y < end.y; ++y)
      for (int x = begin.x; x < end.x; ++x) {
        ivec2 texel = ivec2(x, y);
        ivec2 label = texelFetch(labels, texel, 0).xy;
        vec3 normal;
        vec4 point = surface_at(texel, normal);
        if (label.x != cell) continue;
        leaf_low = min(leaf_low, point.xyz);
        leaf_high = max(leaf_high, point.xyz);
        if (largest == 0.0) leaf_face = normal;
        if (face == vec3(0.0)) face = normal;
        leaf_cosine = min(leaf_cosine, dot(leaf_face, normal));
        cosine = min(cosine, dot(face, normal));
        largest = max(largest, max(point.w, 1e-30));
        inside += float(label.y) / 65536.0;
        area += point.w * float(label.y) / 65536.0;
      }
    low = min(low, leaf_low);
    high = max(high, leaf_high);
    bool whole = inside > float(side * side) - 0.5;
    spheres[leaf] = sphere_around(leaf_low, leaf_high);
    cells[cell].leaf[leaf].sphere = spheres[leaf];
    cells[cell].leaf[leaf].area = vec4(whole ? largest : 4.0 * largest, leaf_cosine, 0.0, 0.0);
  }
  float size = float(buffer_size);
  vec4 sphere = sphere_around(low, high);
  cells[cell].sphere = sphere;
  for (int leaf = 0; leaf < CELL_LEAVES; ++leaf) cells[cell].leaf_codes[leaf] = code_of(spheres[leaf], sphere);
  cells[cell].cone = vec4(face, cosine);
  cells[cell].area = vec4(area / (size * size), sphere.w, 0.0, 0.0);
}
