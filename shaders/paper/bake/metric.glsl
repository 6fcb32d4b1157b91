// The metric of triangles, from their corners in space and in (u, v).
#include "shared.h"
layout(binding = UNIT_CORNER_UVS) uniform samplerBuffer corner_uvs;
layout(binding = UNIT_VERTICES) uniform samplerBuffer vertices;

float cross2(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

vec2 uv_of(int triangle, int corner) {
  vec4 pair = texelFetch(corner_uvs, 2 * triangle + corner / 2);
  return corner == 1 ? pair.zw : pair.xy;
}

int chart_of(int triangle) { return int(texelFetch(corner_uvs, 2 * triangle + 1).z); }

vec3 position_of(int corner) { return texelFetch(vertices, 2 * corner).xyz; }
vec3 normal_of(int corner) { return texelFetch(vertices, 2 * corner + 1).xyz; }

// |P_u x P_v| of a triangle with these edges in space.
float area_element(int triangle, vec3 edge1, vec3 edge2) {
  return length(cross(edge1, edge2)) * texelFetch(corner_uvs, 2 * triangle + 1).w;
}

// E, F, G of a triangle (paper eq. 1) and its area element.
vec4 form_of(int triangle) {
  int corner = 3 * triangle;
  vec3 origin = position_of(corner), edge1 = position_of(corner + 1) - origin, edge2 = position_of(corner + 2) - origin;
  vec2 start = uv_of(triangle, 0), way1 = uv_of(triangle, 1) - start, way2 = uv_of(triangle, 2) - start;
  float area = cross2(way1, way2);
  vec3 along_u = (edge1 * way2.y - edge2 * way1.y) / area, along_v = (edge2 * way1.x - edge1 * way2.x) / area;
  return vec4(dot(along_u, along_u), dot(along_u, along_v), dot(along_v, along_v), area_element(triangle, edge1, edge2));
}
