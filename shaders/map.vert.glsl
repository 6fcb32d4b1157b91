#version 450 core
// Mesh triangles → texture space, as bake.vert, with a map's value at each vertex.
layout(location = 0) in vec4 map;
layout(location = 1) in vec2 uv;

out vec4 surface_map;

void main() {
  surface_map = map;
  gl_Position = vec4(uv * 2.0 - 1.0, -1.0, 1.0);
}
