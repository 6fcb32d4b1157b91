#version 450 core
// Adds one to a texel for every triangle that owns it: more than one means an overlap in the UV map.
layout(location = 0) out vec4 owners;

void main() { owners = vec4(1.0); }
