#version 450 core
// Chart edge → the map at texels whose center lies off the chart: that of the nearest point of the nearest edge, as in edge.frag.
#include "shared.h"
layout(std430, binding = BINDING_EDGES) readonly buffer Edges { EdgeData edges[]; };
layout(std430, binding = BINDING_MAP_EDGES) readonly buffer MapEdges { vec4 map_ends[]; };
layout(location = 0) uniform int buffer_size;

flat in int edge;
layout(location = 0) out vec4 map;

void main() {
  vec4 uv = edges[edge].uv * float(buffer_size);
  vec2 along = uv.zw - uv.xy;
  float square = dot(along, along);
  float t = square > 0.0 ? clamp(dot(gl_FragCoord.xy - uv.xy, along) / square, 0.0, 1.0) : 0.0;
  float distance = length(gl_FragCoord.xy - (uv.xy + along * t));
  map = mix(map_ends[2 * edge], map_ends[2 * edge + 1], t);
  gl_FragDepth = 0.25 + 0.5 * clamp(distance / 2.0, 0.0, 1.0);
}
