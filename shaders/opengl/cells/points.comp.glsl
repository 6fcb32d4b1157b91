#version 450 core
// One invocation per sample of the lists → its surface point, stored next to its neighbors', because centers fetch it many times.
#include "variant.glsl"
#include "opengl/evaluate/buffers.glsl"
#include "opengl/elements.glsl"
layout(binding = UNIT_SAMPLES) uniform isamplerBuffer sample_list;
layout(std430, binding = BINDING_POINTS) writeonly restrict buffer Points { vec4 points[]; };

void main() {
  int index = own_element();
  if (index >= last) return;
  ivec2 entry = texelFetch(sample_list, index).xy;
  vec3 normal;
  ivec2 texel = min(ivec2(entry.x & 0xffff, entry.x >> 16), buffer_size - 1); // entries beyond the list's end are arbitrary
  vec4 point = surface_at(texel, normal);
  points[2 * index] = vec4(point.xyz, point.w * intBitsToFloat(entry.y));
  points[2 * index + 1] = vec4(normal, extent_of_texel(point.w));
}
