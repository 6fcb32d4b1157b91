#version 450 core
// One invocation per patch of triangles → the sphere around it, and its area. Only the sphere's middle is in the mesh's units.
#include "opengl/elements.glsl"
#include "opengl/surface/positions.glsl"
#include "opengl/surface/space.glsl"
layout(binding = UNIT_PATCH_TRIANGLES) uniform isamplerBuffer patch_triangles;
layout(std430, binding = BINDING_PATCH_SPHERES) writeonly restrict buffer Spheres { vec4 spheres[]; };

void main() {
  int patch_number = own_element();
  if (patch_number >= last) return;
  int begin = PATCH_TRIANGLES * patch_number, end = begin;
  vec3 low = vec3(3.0e38), high = -low;
  float area = 0.0, scale = float(center_and_scale.w);
  for (; end < begin + PATCH_TRIANGLES; ++end) {
    ivec4 corners = texelFetch(patch_triangles, 2 * end);
    if (corners.x < 0) break;
    vec3 a = mesh_position(corners.x), b = mesh_position(corners.y), c = mesh_position(corners.z);
    low = min(low, min(a, min(b, c)));
    high = max(high, max(a, max(b, c)));
    area += 0.5 * length(cross(scale * (b - a), scale * (c - a)));
  }
  vec3 middle = 0.5 * low + 0.5 * high;
  float radius = 0.0;
  for (int code = begin; code < end; ++code) {
    ivec4 corners = texelFetch(patch_triangles, 2 * code);
    for (int i = 0; i < 3; ++i) radius = max(radius, length(scale * (mesh_position(corners[i]) - middle)));
  }
  spheres[2 * patch_number] = vec4(middle, radius);
  spheres[2 * patch_number + 1] = vec4(area, 0.0, 0.0, 0.0);
}
