#version 450 core
// One invocation per baked texel → the same texel of the displaced surface: p + n h, its normal and its area element.
#include "variant.glsl"
#include "paper/bake/owner.glsl"
#include "kernel/displace.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = UNIT_INPUT_UV) uniform samplerBuffer input_uvs;
layout(binding = UNIT_TANGENTS) uniform samplerBuffer tangents;
layout(binding = UNIT_HEIGHTS) uniform sampler2D heights;
layout(binding = UNIT_COLORS) uniform sampler2D colors;
layout(binding = IMAGE_POSITION) writeonly restrict uniform image2D positions;
layout(binding = IMAGE_NORMAL) writeonly restrict uniform image2D normals;
layout(location = LOCATION_BUFFER_SIZE) uniform int buffer_size;
layout(location = LOCATION_FIRST) uniform int first_row;
layout(location = LOCATION_MIDLEVEL) uniform float midlevel;
layout(location = LOCATION_HEIGHT_SCALE) uniform float scale;

vec2 input_uv_of(int corner) { return texelFetch(input_uvs, corner).xy; }
vec4 tangent_of(int corner) { return texelFetch(tangents, 2 * corner); }
vec3 frame_normal_of(int corner) { return texelFetch(tangents, 2 * corner + 1).xyz; }

// Wraps pixel numbers, which are whole, into the image. Software devices divide floats many at a time, but integers one by one.
ivec4 wrapped(vec4 pixel, float size) { return ivec4(pixel - size * floor((pixel + 0.5) / size)); }

// The color, bilinear between pixel centers.
vec3 color_at(vec2 uv) {
  vec2 size = vec2(textureSize(colors, 0));
  vec2 position = (uv - floor(uv)) * size - 0.5;
  vec2 t = position - floor(position);
  ivec2 low = ivec2(wrapped(floor(position.xxxx), size.x).x, wrapped(floor(position.yyyy), size.y).x);
  ivec2 high = ivec2(wrapped(floor(position.xxxx) + 1.0, size.x).x, wrapped(floor(position.yyyy) + 1.0, size.y).x);
  return mix(mix(texelFetch(colors, low, 0), texelFetch(colors, ivec2(high.x, low.y), 0), t.x),
             mix(texelFetch(colors, ivec2(low.x, high.y), 0), texelFetch(colors, high, 0), t.x), t.y).xyz;
}

float height_at(int x, int y) { return texelFetch(heights, ivec2(x, y), 0).x; }

// The height and its gradient by the caller's (u, v), in buffer units: bilinear lookups here and one pixel away on each side,
// which share pixels.
vec3 look_up_height(vec2 uv) {
  vec2 size = vec2(textureSize(heights, 0));
  vec2 position = (uv - floor(uv)) * size - 0.5;
  vec2 t = position - floor(position);
  ivec4 x = wrapped(floor(position.x) + vec4(-1.0, 0.0, 1.0, 2.0), size.x);
  ivec4 y = wrapped(floor(position.y) + vec4(-1.0, 0.0, 1.0, 2.0), size.y);
  vec2 below = vec2(height_at(x.y, y.x), height_at(x.z, y.x)), above = vec2(height_at(x.y, y.w), height_at(x.z, y.w));
  vec4 low = vec4(height_at(x.x, y.y), height_at(x.y, y.y), height_at(x.z, y.y), height_at(x.w, y.y));
  vec4 high = vec4(height_at(x.x, y.z), height_at(x.y, y.z), height_at(x.z, y.z), height_at(x.w, y.z));
  vec2 column = mix(low.yz, high.yz, t.y);
  vec2 rise = mix(high.yz - below, above - low.yz, t.y);
  vec2 run = mix(low.zw - low.xy, high.zw - high.xy, t.y);
  return scale * vec3(mix(column.x, column.y, t.x) - midlevel, 0.5 * size * vec2(mix(run.x, run.y, t.x), mix(rise.x, rise.y, t.x)));
}

vec3 normal_of_map(int corner, vec3 part, vec2 uv, vec3 otherwise) {
  vec4 first = tangent_of(corner);
  vec3 tangent = first.xyz * part.x + tangent_of(corner + 1).xyz * part.y + tangent_of(corner + 2).xyz * part.z;
  vec3 n = frame_normal_of(corner) * part.x + frame_normal_of(corner + 1) * part.y + frame_normal_of(corner + 2) * part.z;
  vec3 color = color_at(uv) * 2.0 - 1.0;
  return unit_or(tangent * color.x + first.w * cross(n, tangent) * color.y + n * color.z, otherwise);
}

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.x, first_row + int(gl_GlobalInvocationID.y));
  if (any(greaterThanEqual(texel, ivec2(buffer_size)))) return;
  int triangle;
  vec3 part;
  if (!find_owner(texel, triangle, part)) return;
  int corner = 3 * triangle;
  vec2 map = input_uv_of(corner), way1 = input_uv_of(corner + 1) - map, way2 = input_uv_of(corner + 2) - map;
  vec2 uv = map + way1 * part.y + way2 * part.z;
  vec3 position = position_of(corner), edge1 = position_of(corner + 1) - position, edge2 = position_of(corner + 2) - position;
  position += edge1 * part.y + edge2 * part.z;
  vec3 raw = normal_of(corner), turn1 = normal_of(corner + 1) - raw, turn2 = normal_of(corner + 2) - raw;
  raw += turn1 * part.y + turn2 * part.z;
  float span = max(length(raw), 1e-20);
  vec3 n = raw / span;
  vec3 normal = n;
  float ratio = 1.0;
#if DISPLACED
  vec3 height = look_up_height(uv);
  Displaced moved = displace(edge1, edge2, change_of_edge(turn1, way1, n, span, height), change_of_edge(turn2, way2, n, span, height), n);
  normal = moved.normal;
  ratio = moved.area_ratio;
  position += n * height.x;
#endif
#if NORMAL_MAPPED
  normal = normal_of_map(corner, part, uv, normal);
#endif
  imageStore(positions, texel, vec4(position, area_element(triangle, edge1, edge2) * ratio));
  imageStore(normals, texel, vec4(normal, 0.0));
}
