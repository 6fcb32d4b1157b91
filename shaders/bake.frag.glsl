#version 450 core
// Interpolated triangle → one texel of the geometry buffer: the surface point at the texel's center.
#include "shared.h"
layout(binding = UNIT_TRIANGLES) uniform sampler2D triangles;
layout(location = LOCATION_AREA_UNIT) uniform float area_unit;
layout(location = LOCATION_AREA_LIMIT) uniform float area_limit;

in vec3 surface_position;
in vec3 surface_normal;
flat in int surface_chart;

layout(location = 0) out vec4 position_area;
layout(location = 1) out vec4 normal;
layout(location = 2) out ivec2 ids;

void main() {
  float area = texelFetch(triangles, list_place(gl_PrimitiveID), 0).w;
  position_area = vec4(surface_position, min(area / area_unit, area_limit));
  normal = vec4(normalize(surface_normal), 0.0);
  ids = ivec2(surface_chart, gl_PrimitiveID);
}
