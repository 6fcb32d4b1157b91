#version 450 core
// Square blocks of texels → the largest area element in each, which decides how densely a block is sampled.
#include "buffers.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) writeonly restrict uniform image2D blocks;
layout(location = 8) uniform int block_size;

void main() {
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(block, imageSize(blocks)))) return;
  float largest = 0.0;
  for (int i = 0; i < block_size * block_size; ++i) {
    ivec2 texel = min(block * block_size + ivec2(i % block_size, i / block_size), ivec2(buffer_size - 1));
    largest = max(largest, texelFetch(positions, texel, 0).w);
  }
  imageStore(blocks, block, vec4(largest));
}
