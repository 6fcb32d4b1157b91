#version 450 core
// Interpolated triangle → one texel of the geometry buffer: the surface point at the texel's center.
#include "shared.h"
#include "texel.glsl"
layout(binding = UNIT_TRIANGLES) uniform sampler2D triangles;
layout(location = LOCATION_FIRST_TRIANGLE) uniform int first_triangle;

in vec3 surface_position;
in vec3 surface_normal;
flat in int surface_chart;

void main() {
  int triangle = first_triangle + gl_PrimitiveID;
  store_texel(surface_position, normalize(surface_normal), texelFetch(triangles, list_place(triangle), 0).w);
  ids = ivec2(surface_chart, triangle);
}
