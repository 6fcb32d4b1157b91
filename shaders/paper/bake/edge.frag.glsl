#version 450 core
// Chart edge → texels whose centers lie off the chart: each stands for the nearest point of the nearest edge. Texels of triangles
// have depth 0 and win.
#include "paper/bake/chart_edge.glsl"

flat in int edge;
layout(location = 0) out ivec2 ids;
layout(location = 1) out vec2 weights;

void main() {
  EdgeData data = edge_at(edge);
  vec4 uv = data.uv * float(buffer_size);
  vec2 along = uv.zw - uv.xy;
  float square = dot(along, along);
  float t = square > 0.0 ? clamp(dot(gl_FragCoord.xy - uv.xy, along) / square, 0.0, 1.0) : 0.0;
  float distance = length(gl_FragCoord.xy - (uv.xy + along * t));
  vec2 first = vec2(equal(data.owner.zz, ivec2(1, 2))), second = vec2(equal(data.owner.ww, ivec2(1, 2)));
  weights = mix(first, second, t);
  ids = ivec2(data.owner.x, -1 - data.owner.y); // below 0: the texel's center is not on the chart
  gl_FragDepth = 0.25 + 0.5 * clamp(distance / 2.0, 0.0, 1.0);
}
