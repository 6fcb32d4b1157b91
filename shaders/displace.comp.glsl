#version 450 core
// One invocation, one baked texel → the same texel of the mapped surface: p + n h, its normal and its area element. The formulas are those of
// bake/surface_maps.cpp, where they are explained.
#include "shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = BINDING_BAKE_MOVING) readonly restrict buffer Moving { float moving[]; }; // position, normal of each bake vertex
layout(std430, binding = BINDING_BAKE_FIXED) readonly restrict buffer Fixed { float fixed_[]; };   // (u, v) of the layout, chart
layout(std430, binding = BINDING_BAKE_INDEX) readonly restrict buffer Index { uint index[]; };
layout(std430, binding = BINDING_MAP_UV) readonly restrict buffer MapUv { vec2 map_uv[]; };
layout(std430, binding = BINDING_TANGENTS) readonly restrict buffer Tangents { vec4 tangents[]; }; // tangent, normal of each corner
layout(binding = UNIT_TRIANGLES) uniform sampler2D triangles;
layout(binding = UNIT_IDS) uniform isampler2D ids;
layout(binding = UNIT_HEIGHTS) uniform sampler2D heights;
layout(binding = UNIT_COLORS) uniform sampler2D colors;
layout(binding = 0) writeonly restrict uniform image2D positions;
layout(binding = 1) writeonly restrict uniform image2D normals;
layout(location = 0) uniform int buffer_size;
layout(location = 1) uniform int displaced;
layout(location = 2) uniform int normal_mapped;
layout(location = 3) uniform float midlevel;
layout(location = 4) uniform float scale; // in buffer units

vec3 position_of(uint v) { return vec3(moving[6u * v], moving[6u * v + 1u], moving[6u * v + 2u]); }
vec3 normal_of(uint v) { return vec3(moving[6u * v + 3u], moving[6u * v + 4u], moving[6u * v + 5u]); }
vec2 place_of(uint v) { return vec2(fixed_[3u * v], fixed_[3u * v + 1u]); }
float cross2(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }
vec3 unit_or(vec3 v, vec3 other) {
  float span = length(v);
  return span > 0.0 ? v / span : other;
}

// Repeats, bilinear between the centers of pixels.
vec4 look_up(sampler2D image, vec2 uv) {
  ivec2 size = textureSize(image, 0);
  vec2 place = (uv - floor(uv)) * vec2(size) - 0.5;
  vec2 t = place - floor(place);
  ivec2 low = (ivec2(floor(place)) + size) % size;
  ivec2 high = (low + 1) % size;
  return mix(mix(texelFetch(image, low, 0), texelFetch(image, ivec2(high.x, low.y), 0), t.x),
             mix(texelFetch(image, ivec2(low.x, high.y), 0), texelFetch(image, high, 0), t.x), t.y);
}

// The parameter of the point of a segment from a that is nearest to the origin.
float nearest_on(vec2 a, vec2 way) { return clamp(-dot(a, way) / max(dot(way, way), 1e-30), 0.0, 1.0); }

// Barycentric coordinates of corners 1 and 2, of the triangle's point nearest to the texel's center; corners relative to that.
vec2 nearest_place(vec2 c0, vec2 c1, vec2 c2) {
  float area = cross2(c1 - c0, c2 - c0);
  vec3 inside = vec3(cross2(c1, c2), cross2(c2, c0), cross2(c0, c1)) / (abs(area) > 0.0 ? area : 1.0);
  if (abs(area) > 0.0 && all(greaterThanEqual(inside, vec3(0.0)))) return inside.yz;
  float t0 = nearest_on(c0, c1 - c0), t1 = nearest_on(c1, c2 - c1), t2 = nearest_on(c2, c0 - c2);
  vec2 p0 = mix(c0, c1, t0), p1 = mix(c1, c2, t1), p2 = mix(c2, c0, t2);
  vec3 away = vec3(dot(p0, p0), dot(p1, p1), dot(p2, p2));
  if (away.x <= away.y && away.x <= away.z) return vec2(t0, 0.0);
  return away.y <= away.z ? vec2(1.0 - t1, t1) : vec2(0.0, 1.0 - t2);
}

// The height and its gradient by the caller's (u, v), in buffer units.
vec3 look_up_height(vec2 uv) {
  vec2 size = vec2(textureSize(heights, 0));
  vec2 x = vec2(1.0 / size.x, 0.0), y = vec2(0.0, 1.0 / size.y);
  vec2 slope = 0.5 * size * vec2(look_up(heights, uv + x).x - look_up(heights, uv - x).x, look_up(heights, uv + y).x - look_up(heights, uv - y).x);
  return scale * vec3(look_up(heights, uv).x - midlevel, slope);
}

vec3 mapped_normal(int corner, vec2 place, vec2 uv, vec3 otherwise) {
  vec3 part = vec3(1.0 - place.x - place.y, place);
  vec4 tangent = tangents[2 * corner] * part.x + tangents[2 * corner + 2] * part.y + tangents[2 * corner + 4] * part.z;
  vec3 n = tangents[2 * corner + 1].xyz * part.x + tangents[2 * corner + 3].xyz * part.y + tangents[2 * corner + 5].xyz * part.z;
  vec3 color = look_up(colors, uv).xyz * 2.0 - 1.0;
  return unit_or(tangent.xyz * color.x + tangents[2 * corner].w * cross(n, tangent.xyz) * color.y + n * color.z, otherwise);
}

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(texel, ivec2(buffer_size)))) return;
  ivec2 id = texelFetch(ids, texel, 0).xy;
  if (id.x < 0) return;
  int triangle = id.y < 0 ? -1 - id.y : id.y;
  uint v0 = index[3 * triangle], v1 = index[3 * triangle + 1], v2 = index[3 * triangle + 2];
  vec2 center = (vec2(texel) + 0.5) / float(buffer_size);
  vec2 place = nearest_place(place_of(v0) - center, place_of(v1) - center, place_of(v2) - center);
  vec2 way1 = map_uv[v1] - map_uv[v0], way2 = map_uv[v2] - map_uv[v0];
  vec2 uv = map_uv[v0] + way1 * place.x + way2 * place.y;
  vec3 edge1 = position_of(v1) - position_of(v0), edge2 = position_of(v2) - position_of(v0);
  vec3 turn1 = normal_of(v1) - normal_of(v0), turn2 = normal_of(v2) - normal_of(v0);
  vec3 position = position_of(v0) + edge1 * place.x + edge2 * place.y;
  vec3 raw = normal_of(v0) + turn1 * place.x + turn2 * place.y;
  float span = max(length(raw), 1e-20);
  vec3 n = raw / span;
  vec3 normal = n;
  float ratio = 1.0;
  if (displaced != 0) {
    vec3 height = look_up_height(uv);
    vec3 change1 = (turn1 - n * dot(n, turn1)) * (height.x / span) + n * dot(height.yz, way1);
    vec3 change2 = (turn2 - n * dot(n, turn2)) * (height.x / span) + n * dot(height.yz, way2);
    vec3 t1 = edge1 - n * dot(n, edge1), t2 = edge2 - n * dot(n, edge2);
    float side = dot(cross(t1, t2), n) < 0.0 ? -1.0 : 1.0;
    normal = unit_or(side * cross(t1 + change1, t2 + change2), n);
    ratio = length(cross(edge1 + change1, edge2 + change2)) / max(length(cross(edge1, edge2)), 1e-30);
    position += n * height.x;
  }
  if (normal_mapped != 0) normal = mapped_normal(3 * triangle, place, uv, normal);
  imageStore(positions, texel, vec4(position, texelFetch(triangles, list_place(triangle), 0).w * ratio));
  imageStore(normals, texel, vec4(normal, 0.0));
}
