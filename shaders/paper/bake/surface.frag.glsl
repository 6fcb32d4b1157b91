#version 450 core
// A texel of a layout → its surface point, with interpolated position and normal (paper 3.3).
#include "variant.glsl"
#include "paper/bake/owner.glsl"
#include "paper/bake/texel.glsl"

void main() {
  int triangle;
  vec3 part;
  bool owned = find_owner(ivec2(gl_FragCoord.xy), triangle, part);
  int corner = 3 * triangle;
  vec3 origin = position_of(corner), edge1 = position_of(corner + 1) - origin, edge2 = position_of(corner + 2) - origin;
  vec3 direction = normal_of(corner) * part.x + normal_of(corner + 1) * part.y + normal_of(corner + 2) * part.z;
  store_texel(origin + edge1 * part.y + edge2 * part.z, normalize(direction), area_element(triangle, edge1, edge2));
  if (!owned) clear_texel();
}
