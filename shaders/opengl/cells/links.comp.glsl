#version 450 core
// One invocation per link between cells → a sphere around the points where the surface crosses from one to the other.
#include "opengl/elements.glsl"
layout(std430, binding = BINDING_POINTS) writeonly restrict buffer LinkSpheres { vec4 spheres[]; };
layout(binding = UNIT_CELL_LINKS) uniform isamplerBuffer cell_links;
layout(binding = UNIT_LINK_POINTS) uniform samplerBuffer link_points;

void main() {
  int link = own_element();
  if (link >= last) return;
  ivec2 points = texelFetch(cell_links, link).xy;
  vec3 low = vec3(1e30), high = vec3(-1e30);
  for (int i = points.x; i < points.y; ++i) {
    vec3 point = texelFetch(link_points, 2 * i).xyz;
    low = min(low, point);
    high = max(high, point);
  }
  spheres[link] = vec4(0.5 * (low + high), 0.5 * length(high - low));
}
