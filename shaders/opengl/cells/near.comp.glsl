#version 450 core
// One invocation per cell near the centers of a list → everything that those centers read of it, stored side by side: its sphere,
// whether it faces them, its leaves, and its neighbors among the cells of the same list.
#include "opengl/elements.glsl"
#include "opengl/cells/search.glsl"
layout(std430, binding = BINDING_CELLS) readonly restrict buffer CellList { CellData cells[]; };
layout(std430, binding = BINDING_NEAR_SPHERES) writeonly restrict buffer Spheres { vec4 spheres[]; };
layout(std430, binding = BINDING_NEAR_TRAITS) writeonly restrict buffer Traits { ivec4 traits[]; };
layout(binding = UNIT_NEAR_CELLS) uniform isamplerBuffer near_list;
layout(binding = UNIT_NEAR_LISTS) uniform isamplerBuffer near_lists;
layout(std430, binding = BINDING_NEAR_RANGES) restrict buffer NearRanges { ivec4 near_ranges[]; };
layout(binding = UNIT_NEAR_BALLS) uniform samplerBuffer near_balls;
layout(binding = UNIT_ADJACENCY) uniform isamplerBuffer adjacency;
layout(binding = UNIT_NEAR_NORMALS) uniform samplerBuffer near_normals;
layout(binding = UNIT_CELL_LISTS) uniform isamplerBuffer cell_lists;
layout(binding = UNIT_CELL_TRAITS) uniform isamplerBuffer cell_traits;

const float least_cosine = 0.25; // within 75 degrees hardly any valley is so deep that it leaves the ball of both its sides

vec4 sphere_of(int cell) { return intBitsToFloat(texelFetch(cell_traits, CELL_TRAITS * cell)); }

// The distance from a point to halfway between a cell's middle and its nearest part: this misleads least if cells differ in size.
float away(vec4 sphere, vec3 point) { return length(sphere.xyz - point) - 0.5 * sphere.w; }

// Returns whether some neighbor of a cell is closer to the middle of a ball and on the same list. Following such neighbors leads
// every cell to one that has none: if a list has only one of these, the whole list is connected.
bool has_closer_neighbor(vec4 sphere, ivec2 neighbors, vec4 ball) {
  float own = away(sphere, ball.xyz);
  bool closer = false;
  for (int i = neighbors.x; i < neighbors.y && !closer; ++i) {
    vec4 other = sphere_of(texelFetch(adjacency, i).x);
    float distance = away(other, ball.xyz);
    closer = other.w >= 0.0 && distance < own && distance < ball.w + (LINK_REACH - 0.5) * other.w;
  }
  return closer;
}

void main() {
  int entry = own_element();
  if (entry >= min(last, counts.cells) || !lists_fit()) return;
  int cell = texelFetch(near_list, entry).x;
  ivec2 list = texelFetch(near_lists, entry).xy; // and where its neighbors are stored
  vec4 sphere = sphere_of(cell);
  vec4 cone = intBitsToFloat(texelFetch(cell_traits, CELL_TRAITS * cell + 1));
  ivec4 measured = texelFetch(cell_traits, CELL_TRAITS * cell + 2); // area, radius, CELL_ bits
  vec3 normal = texelFetch(near_normals, list.x).xyz;
  float cosine = dot(normal, cone.xyz), own = clamp(cone.w, -1.0, 1.0);
  // The cosine of the sum of both angles is cosine * own - sqrt(square). The root is not compared: AMD's LLVM crashes on that.
  float rest = max(cosine * own - least_cosine, 0.0), square = (1.0 - cosine * cosine) * (1.0 - own * own);
  bool faces = min(own, cosine) > least_cosine && rest * rest > square;
  ivec2 neighbors = texelFetch(cell_lists, cell).xy;
  if (!has_closer_neighbor(sphere, neighbors, texelFetch(near_balls, list.x))) atomicAdd(near_ranges[list.x].w, 1);
  int first = near_ranges[list.x].z + list.y;
  float projected = intBitsToFloat(measured.x) * max(cosine, 0.0);
  spheres[entry] = sphere;
  traits[NEAR_TRAITS * entry] =
      ivec4(cell, measured.z | (faces ? CELL_FACES_CENTERS : 0), floatBitsToInt(projected), measured.y);
  traits[NEAR_TRAITS * entry + 1] = cells[cell].leaf_codes;
  traits[NEAR_TRAITS * entry + 2] = ivec4(first, first + neighbors.y - neighbors.x, list.x, 0);
}
