#version 450 core
// One invocation, one link between cells → a sphere around the points where the surface goes over.
#include "device.glsl"
#include "shared.h"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_POINTS) writeonly restrict buffer LinkSpheres { vec4 spheres[]; };
layout(binding = UNIT_CELL_LINKS) uniform isamplerBuffer cell_links;
layout(binding = UNIT_LINK_POINTS) uniform samplerBuffer link_points;
layout(location = LOCATION_FIRST) uniform int first;
layout(location = LOCATION_LAST) uniform int last;

void main() {
  int link = first + int(gl_GlobalInvocationID.x);
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
