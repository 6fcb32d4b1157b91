#version 450 core
// Chart edge → texels whose center lies off the chart: each stores the nearest point of the nearest edge. Triangle texels have depth 0
// and win.
#include "shared.h"
#include "texel.glsl"
layout(std430, binding = BINDING_EDGES) readonly buffer Edges { EdgeData edges[]; };
layout(location = 0) uniform int buffer_size;
layout(binding = UNIT_TRIANGLES) uniform sampler2D triangles;

flat in int edge;

void main() {
  EdgeData data = edges[edge];
  vec4 uv = data.uv * float(buffer_size);
  vec2 along = uv.zw - uv.xy;
  float square = dot(along, along);
  float t = square > 0.0 ? clamp(dot(gl_FragCoord.xy - uv.xy, along) / square, 0.0, 1.0) : 0.0;
  float distance = length(gl_FragCoord.xy - (uv.xy + along * t));
  int triangle = int(data.position1_triangle.w);
  store_texel(mix(data.position0_chart.xyz, data.position1_triangle.xyz, t), normalize(mix(data.normal0.xyz, data.normal1.xyz, t)),
              texelFetch(triangles, list_place(triangle), 0).w);
  ids = ivec2(int(data.position0_chart.w), -1 - triangle); // below 0: the texel's center is not on the chart
  gl_FragDepth = 0.25 + 0.5 * clamp(distance / 2.0, 0.0, 1.0);
}
