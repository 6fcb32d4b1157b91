#version 450 core
// Adds one for every triangle that owns the texel: more than one is an overlap in the UV map.
layout(location = 0) out vec4 owners;

void main() { owners = vec4(1.0); }
