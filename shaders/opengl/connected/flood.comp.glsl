#version 450 core
// One invocation per ambiguous center → the triangles connected to it within the ball, and whether their area is the one that its
// samples found. If not, the center is computed again, on exactly these triangles.
//
// The flood goes from triangle to triangle across edges that meet the ball. It takes a patch wholly inside the ball in one step.
// There is one loop instead of nested ones, which would run as often as the longest among neighboring invocations in each turn.
#include "variant.glsl"
#include "device.glsl"
#include "opengl/evaluate/params.glsl"
#include "opengl/connected/floods.glsl"
#include "opengl/connected/triangle_in_ball.glsl"
#include "opengl/surface/positions.glsl"
#include "opengl/surface/space.glsl"
layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = BINDING_CENTERS) readonly restrict buffer Centers { CenterData centers[]; };
layout(std430, binding = BINDING_RESULTS) readonly restrict buffer Results { uint results[]; };
layout(binding = UNIT_START_CODES) uniform isamplerBuffer start_codes;
layout(binding = UNIT_PATCH_TRIANGLES) uniform isamplerBuffer patch_triangles;
layout(binding = UNIT_PATCH_RANGES) uniform isamplerBuffer patch_ranges;
layout(binding = UNIT_PATCH_NEIGHBORS) uniform isamplerBuffer patch_neighbors;
layout(binding = UNIT_PATCH_SPHERES) uniform samplerBuffer patch_spheres;

#if FLOOD_PATCHES > MOST_FEW_PATCHES
#include "opengl/connected/many_patches.glsl"
#else
#include "opengl/connected/few_patches.glsl"
#endif

#define NONE 1.0e9

bool is_inside(vec3 offset) { return dot(offset, offset) < 1.0; }

// Returns whether an edge meets the ball.
bool meets(vec3 a, vec3 b) {
  vec3 way = b - a;
  float size = dot(way, way), along = -dot(a, way);
  bool passes = along > 0.0 && along < size && (dot(a, a) - 1.0) * size < along * along;
  return is_inside(a) || is_inside(b) || passes;
}

// A triangle, seen from the center of a unit ball.
struct Offsets {
  vec3 a, b, c;
};

vec3 center; // in the mesh's units
float unit;  // the radius in the mesh's units

Offsets offsets_of(int code) {
  ivec4 corners = texelFetch(patch_triangles, 2 * code);
  return Offsets(unit * (mesh_position(corners.x) - center), unit * (mesh_position(corners.y) - center),
                 unit * (mesh_position(corners.z) - center));
}

bool is_within(int patch_number) {
  vec4 sphere = texelFetch(patch_spheres, 2 * patch_number);
  return length(unit * (sphere.xyz - center)) + sphere.w / params.radius < 1.0;
}

float area_of_patch(int patch_number) { return texelFetch(patch_spheres, 2 * patch_number + 1).x / (params.radius * params.radius); }

#define NO_ROOM 0
#define TOO_LONG 1
#define ENDED 2

// area: the approximate area reached, in squared radii; 0 if triangles are too large to estimate it.
int run(int start, out float area) {
  const float large = 1.5; // squared side lengths above this
  area = 0.0;
  int place = -1, patch_number = -1;
  uint reached = 0u, pending = 0u; // bits of the patch's triangles
  ivec2 neighbors = ivec2(0);
  ivec3 beyond = ivec3(start, -1, -1); // codes of triangles in other patches
  begin_flood();
  for (int turn = 0; turn < MAX_ITERATIONS / 3; ++turn) { // rounds of reach() count, too
    int to = -1, code = max(beyond.x, max(beyond.y, beyond.z));
    uint bits = 0u;
    if (code >= 0) {
      beyond = mix(beyond, ivec3(-1), equal(beyond, ivec3(code)));
      to = code / PATCH_TRIANGLES;
      bits = 1u << (code & PATCH_TRIANGLES - 1);
    } else if (neighbors.x < neighbors.y) {
      ivec2 neighbor = texelFetch(patch_neighbors, neighbors.x++).xy;
      to = neighbor.x;
      bits = uint(neighbor.y);
    }
    if (to >= 0 && !reach(to, bits)) return NO_ROOM;
    if (any(greaterThanEqual(beyond, ivec3(0))) || neighbors.x < neighbors.y) continue;
    if (pending == 0u) {
      if (!next_patch(place, patch_number, reached, pending)) return ENDED;
      if (is_within(patch_number)) {
        area += area_of_patch(patch_number);
        reached = ~0u;
        pending = 0u;
        neighbors = texelFetch(patch_ranges, patch_number).xy;
      }
    }
    if (pending != 0u) {
      uint bit = pending & -pending;
      pending ^= bit;
      reached |= bit;
      int own = PATCH_TRIANGLES * patch_number + findLSB(bit);
      ivec4 across = texelFetch(patch_triangles, 2 * own + 1);
      Offsets at = offsets_of(own);
      vec3 squares = vec3(dot(at.a, at.a), dot(at.b, at.b), dot(at.c, at.c));
      vec3 ways = vec3(dot(at.b - at.a, at.b - at.a), dot(at.c - at.b, at.c - at.b), dot(at.a - at.c, at.a - at.c));
      float sides = ways.x + ways.y + ways.z;
      area += 0.5 * length(cross(at.b - at.a, at.c - at.a)) * part_in_ball(squares, sides);
      if (sides > large && any(greaterThan(squares, vec3(1.0)))) area = NONE;
      bvec3 met = bvec3(meets(at.a, at.b), meets(at.b, at.c), meets(at.c, at.a));
      for (int side = 0; side < 3; ++side) {
        if (!met[side] || across[side] < 0) continue;
        if (across[side] / PATCH_TRIANGLES == patch_number)
          pending |= 1u << (across[side] & PATCH_TRIANGLES - 1) & ~reached;
        else
          beyond[side] = across[side];
      }
    }
  }
  return TOO_LONG;
}

// The exact area of a flood that has ended.
float exact_area() {
  float area = 0.0;
  int patch_number = -1;
  uint left = 0u;
  for (int place = 0; place < FLOOD_PLACES || left != 0u;) {
    if (left == 0u) {
      patch_number = patch_in(place);
      left = patch_number >= 0 ? reached_in(place) : 0u;
      ++place;
      if (left != 0u && is_within(patch_number)) {
        area += area_of_patch(patch_number);
        left = 0u;
      }
    } else {
      Offsets at = offsets_of(PATCH_TRIANGLES * patch_number + findLSB(left));
      left &= left - 1u;
      area += triangle_in_ball(at.a, at.b, at.c);
    }
  }
  return area;
}

// Stores the flood for a center that is computed again.
void keep(int center_number) {
  int again = atomicAdd(connected[CONNECTED_AGAIN], 1), table = table_again(again);
  atomicMax(connected[CONNECTED_AGAIN_GROUPS], again / GROUP_SIZE + 1);
  connected[center_again(again)] = center_number;
  for (int i = 0; i < params.flood_table; ++i) connected[table + 2 * i] = -1;
  for (int place = 0; place < FLOOD_PLACES; ++place) {
    int patch_number = patch_in(place);
    if (patch_number < 0) continue;
    int to = first_place(patch_number, params.flood_table);
    while (connected[table + 2 * to] >= 0) to = to + 1 & params.flood_table - 1;
    connected[table + 2 * to] = patch_number;
    connected[table + 2 * to + 1] = int(reached_in(place));
  }
}

void main() {
  int i = params.first + int(gl_GlobalInvocationID.x);
  if (i >= min(params.last, connected[CONNECTED_AMBIGUOUS])) return;
  int number = connected[ambiguous_center(i)];
  center = vec3(dvec3(centers[number].position) / center_and_scale.w + center_and_scale.xyz);
  unit = float(center_and_scale.w) / params.radius;
  float area;
  int end = run(texelFetch(start_codes, number).x, area);
  atomicMax(connected[CONNECTED_PATCHES], patches);
  float sampled = uintBitsToFloat(results[ROW_AREA * params.total + number]) / (params.radius * params.radius);
  if (end != ENDED || abs(area - sampled) < 0.75 * params.area_tolerance) return;
  area = exact_area();
  if (area > 0.0 && abs(area - sampled) >= params.area_tolerance) keep(number);
}
