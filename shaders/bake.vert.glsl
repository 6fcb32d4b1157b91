#version 450 core
// Mesh triangles → texture space: (u, v) is the place on the screen (paper 3.3).
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in int chart;

out vec3 surface_position;
out vec3 surface_normal;
flat out int surface_chart;

void main() {
  surface_position = position;
  surface_normal = normal;
  surface_chart = chart;
  gl_Position = vec4(uv * 2.0 - 1.0, -1.0, 1.0);
}
