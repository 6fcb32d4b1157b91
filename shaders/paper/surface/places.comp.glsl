#version 450 core
// One invocation per bake vertex → its position in buffer units, and its normal.
#include "paper/elements.glsl"
#include "paper/surface/mesh.glsl"
// Subtracting a center and multiplying by a scale leads from the caller's units to those of the buffers.
layout(std140, binding = BLOCK_SPACE) uniform Space { dvec4 center_and_scale; };
layout(std430, binding = BINDING_PLACES) writeonly restrict buffer Places { vec4 places[]; };
layout(binding = UNIT_MESH_NORMALS) uniform samplerBuffer mesh_normals;
layout(binding = UNIT_SOURCES) uniform isamplerBuffer sources;

void main() {
  int place = own_element();
  if (place >= last) return;
  ivec2 source = texelFetch(sources, place).xy;
  vec3 position = vec3((dvec3(mesh_position(source.x)) - center_and_scale.xyz) * center_and_scale.w);
  places[2 * place] = vec4(position, 0.0);
  places[2 * place + 1] = vec4(texelFetch(mesh_normals, source.y).xyz, 0.0);
}
