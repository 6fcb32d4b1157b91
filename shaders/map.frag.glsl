#version 450 core
// Interpolated map → one texel: its value at the texel's center.
in vec4 surface_map;
layout(location = 0) out vec4 map;

void main() { map = surface_map; }
