#version 450 core
// Three vertices → a triangle that covers the screen, with one fragment per texel.
void main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0.0, 1.0); }
