#version 450 core
// One invocation, one sample of the lists → its point of the surface, beside those of its neighbors: centers fetch it many times.
#include "variant.glsl"
#include "device.glsl"
#include "opengl/evaluate/buffers.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(binding = UNIT_SAMPLES) uniform isamplerBuffer sample_list;
layout(std430, binding = BINDING_POINTS) writeonly restrict buffer Points { vec4 points[]; };
layout(location = LOCATION_FIRST) uniform int first;
layout(location = LOCATION_LAST) uniform int last;

void main() {
  int index = first + int(gl_GlobalInvocationID.x);
  if (index >= last) return;
  ivec2 entry = texelFetch(sample_list, index).xy;
  vec3 normal;
  vec4 point = surface_at(ivec2(entry.x & 0xffff, entry.x >> 16), normal);
  points[2 * index] = vec4(point.xyz, point.w * intBitsToFloat(entry.y));
  points[2 * index + 1] = vec4(normal, extent_of_texel(point.w));
}
