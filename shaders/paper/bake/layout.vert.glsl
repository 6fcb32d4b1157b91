#version 450 core
// Mesh triangles → texture space: (u, v) is the position on the screen (paper 3.3).
#include "paper/bake/metric.glsl"

flat out int triangle;

void main() {
  triangle = gl_VertexID / 3;
  gl_Position = vec4(uv_of(triangle, gl_VertexID % 3) * 2.0 - 1.0, -1.0, 1.0);
}
