#version 450 core
// Chart edges → quads that cover every texel an edge passes through, so that no chart falls apart (paper 3.3). A rasterized line
// would skip texels that the edge only touches.
#include "paper/bake/chart_edge.glsl"

flat out int edge;

// Half a texel's diagonal, in texels: the largest distance between a touched texel's center and the edge.
const float HALF_DIAGONAL = 0.7072;

void main() {
  edge = gl_VertexID / 6;
  const vec2 corners[6] = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));
  vec2 corner = corners[gl_VertexID % 6];
  vec4 uv = edge_at(edge).uv * float(buffer_size);
  vec2 along = uv.zw - uv.xy;
  float span = length(along);
  along = span > 0.0 ? along / span : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  vec2 position = (corner.x < 0.0 ? uv.xy - along * HALF_DIAGONAL : uv.zw + along * HALF_DIAGONAL) + across * corner.y * HALF_DIAGONAL;
  gl_Position = vec4(position / float(buffer_size) * 2.0 - 1.0, 0.0, 1.0);
}
