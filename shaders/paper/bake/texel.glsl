// A point of the surface → one texel of the geometry buffer, in 32 or 16 bits.
#include "paper/bake/half.glsl"
layout(location = LOCATION_AREA_UNIT) uniform float area_unit;

layout(location = 0) out vec4 position_area;
layout(location = 1) out vec4 normal;

// In 16 bits the normal is stored as a position on the octahedron; the unused numbers store its rounding error and the
// position's.
void store_texel(vec3 position, vec3 direction, float area_element) {
  float area = area_element / area_unit;
#ifdef HALF_FLOATS
  position_area = vec4(nearest_half(position), nearest_half(min(area, 65504.0)));
  vec2 octahedral = to_octahedron(direction);
  vec2 rounded = nearest_half(octahedral);
  normal = vec4(rounded, code_of_two(octahedral - rounded), code_of_three(position - position_area.xyz));
#else
  position_area = vec4(position, area);
  normal = vec4(direction, 0.0);
#endif
}

// Marks a texel without surface.
void clear_texel() {
  position_area = vec4(0.0);
  normal = vec4(0.0);
}
