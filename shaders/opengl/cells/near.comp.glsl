#version 450 core
// One invocation, one of the cells near a cell in which centers start → all that those centers look at, side by side: where it lies, how
// they see it, its leaves, and its neighbors among the cells of the same list.
#include "shared.h"
#include "opengl/elements.glsl"
layout(std430, binding = BINDING_CELLS) readonly restrict buffer CellList { CellData cells[]; };
layout(std430, binding = BINDING_NEAR_SPHERES) writeonly restrict buffer Spheres { vec4 spheres[]; };
layout(std430, binding = BINDING_NEAR_TRAITS) writeonly restrict buffer Traits { ivec4 traits[]; };
layout(binding = UNIT_NEAR_CELLS) uniform isamplerBuffer near_list;
layout(binding = UNIT_NEAR_NORMALS) uniform samplerBuffer near_normals;
layout(binding = UNIT_CELL_LISTS) uniform isamplerBuffer cell_lists;

const float least_cosine = 0.25; // within 75 degrees hardly a valley is so deep that it leaves the ball of both its sides

void main() {
  int entry = own_element();
  if (entry >= last) return;
  ivec4 near = texelFetch(near_list, entry); // cell, the one that centers start in, where its neighbors go, CELL_ bits
  CellData cell = cells[near.x];
  vec3 normal = texelFetch(near_normals, near.y).xyz;
  float cosine = dot(normal, cell.cone.xyz), own = clamp(cell.cone.w, -1.0, 1.0);
  // The cosine of both angles together is cosine * own minus the root of `square`; AMD's LLVM crashes over a root that is compared.
  float rest = max(cosine * own - least_cosine, 0.0), square = (1.0 - cosine * cosine) * (1.0 - own * own);
  bool faces = min(own, cosine) > least_cosine && rest * rest > square;
  ivec2 neighbors = texelFetch(cell_lists, 2 * near.x).zw;
  float projected = cell.area.x * max(cosine, 0.0);
  spheres[entry] = cell.sphere;
  traits[NEAR_TRAITS * entry] =
      ivec4(near.x, near.w | (faces ? CELL_FACES_CENTERS : 0), floatBitsToInt(projected), floatBitsToInt(cell.area.y));
  traits[NEAR_TRAITS * entry + 1] = cell.leaf_codes;
  traits[NEAR_TRAITS * entry + 2] = ivec4(near.z, near.z + neighbors.y - neighbors.x, near.y, 0);
}
