#version 450 core
// A texel of a layout → its surface point, with interpolated position and normal (paper 3.3).
#include "variant.glsl"
#include "paper/bake/owner.glsl"
#include "paper/bake/texel.glsl"

void main() {
  int triangle;
  ivec4 vertex;
  vec3 part;
  bool owned = find_owner(ivec2(gl_FragCoord.xy), triangle, vertex, part);
  vec3 origin = position_of(vertex.x), edge1 = position_of(vertex.y) - origin, edge2 = position_of(vertex.z) - origin;
  vec3 direction = normal_of(vertex.x) * part.x + normal_of(vertex.y) * part.y + normal_of(vertex.z) * part.z;
  store_texel(origin + edge1 * part.y + edge2 * part.z, normalize(direction), area_element(vertex, edge1, edge2));
  if (!owned) clear_texel();
}
