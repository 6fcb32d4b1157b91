#version 450 core
// One invocation per bake vertex or center → its position in buffer units, and its normal.
#include "opengl/elements.glsl"
#include "opengl/surface/mesh.glsl"
#include "opengl/surface/space.glsl"
layout(std430, binding = BINDING_PLACES) writeonly restrict buffer Places { float places[]; };
layout(binding = UNIT_MESH_NORMALS) uniform samplerBuffer mesh_normals;
layout(binding = UNIT_SOURCES) uniform isamplerBuffer sources;
layout(location = LOCATION_STRIDE) uniform int stride;

void main() {
  int place = own_element();
  if (place >= last) return;
  ivec2 source = texelFetch(sources, place).xy;
  vec3 position = vec3((dvec3(mesh_position(source.x)) - center_and_scale.xyz) * center_and_scale.w);
  vec3 normal = texelFetch(mesh_normals, source.y).xyz;
  for (int i = 0; i < 3; ++i) {
    places[stride * place + i] = position[i];
    places[stride * place + 4 + i] = normal[i];
  }
}
