// The cells near a center: which lie in its ball, and whether these are a single sheet of surface.
layout(binding = UNIT_CELL_LISTS) uniform isamplerBuffer cell_lists;
layout(binding = UNIT_NEAR_SPHERES) uniform samplerBuffer near_spheres;
layout(binding = UNIT_NEAR_TRAITS) uniform isamplerBuffer near_traits;
layout(binding = UNIT_BOUNDARY) uniform samplerBuffer boundary_ends;
layout(binding = UNIT_STARTS) uniform isamplerBuffer start_ranges;
layout(binding = UNIT_START_CELLS) uniform isamplerBuffer start_cells;
layout(location = LOCATION_RANGES) uniform int ranges_of_center; // at most

// As a center sees it.
struct NearSphere {
  vec4 sphere;
  float square; // of the distance of its middle
};

NearSphere near_sphere(int entry, vec3 center) {
  vec4 sphere = texelFetch(near_spheres, entry);
  vec3 gap = sphere.xyz - center;
  return NearSphere(sphere, dot(gap, gap));
}

bool in_ball(NearSphere near) {
  float outer = params.radius + near.sphere.w;
  return near.sphere.w >= 0.0 && near.square < outer * outer;
}

bool within_ball(NearSphere near) {
  float rest = params.radius - near.sphere.w;
  return near.sphere.w >= 0.0 && rest > 0.0 && near.square < rest * rest;
}

struct NearTraits {
  int number, bits; // CELL_
  float projected;  // its area
  float unit;       // of the codes of its leaves
};

NearTraits near_traits_of(int entry) {
  ivec4 traits = texelFetch(near_traits, NEAR_TRAITS * entry);
  return NearTraits(traits.x, traits.y, intBitsToFloat(traits.z), intBitsToFloat(traits.w));
}

bool in_ball(vec3 point, vec3 center) {
  vec3 gap = point - center;
  return dot(gap, gap) < params.radius * params.radius;
}

// Whether an edge on the mesh's boundary meets the ball.
bool edge_in_ball(int edge, vec3 center) {
  vec3 from = texelFetch(boundary_ends, 2 * edge).xyz, way = texelFetch(boundary_ends, 2 * edge + 1).xyz - from;
  float square = dot(way, way);
  float along = square > 0.0 ? clamp(dot(center - from, way) / square, 0.0, 1.0) : 0.0;
  return in_ball(from + along * way, center);
}

bool meets_boundary(int cell, vec3 center) {
  ivec2 edges = texelFetch(cell_lists, cell).zw;
  bool meets = false;
  for (int i = edges.x; i < edges.y && !meets; ++i) meets = edge_in_ball(i, center);
  return meets;
}

// The part of a cell's area that counts: between r^2 - 2 r s and r^2 + 2 r s, so that an even disk has its own area.
float part_in_ball(NearSphere near) {
  float radius = params.radius, across = near.sphere.w;
  return clamp((radius * (radius + 2.0 * across) - near.square) / max(4.0 * radius * across, 1e-30), 0.0, 1.0);
}

// A bit for each cell near the center, in the order of their list: it lies in the ball, and belongs to the neighborhood; for those that go
// over links, an edge on the mesh's boundary runs through it; it has no texels, but may lead on.
uint taken[NEAR_WORDS];
#if OVER_LINKS
uint at_boundary[NEAR_WORDS], leading[NEAR_WORDS];
#endif

// Takes what lies in the ball. all_connected: the cells near the center are. Returns whether all that lies in the ball faces the center's way and covers its tangent plane once: then it is
// connected. That is known not to be so where links are gone over.
bool take_near_cells(vec3 center, ivec2 near_cells, bool all_connected) {
  float flat_area = 0.0;
  bool single = OVER_LINKS == 0 && all_connected && near_cells.x < near_cells.y;
  int k = 0, count = near_cells.y - near_cells.x;
  for (int word = 0; word < NEAR_WORDS; ++word) {
    uint bits = 0u, boundary = 0u, without_points = 0u;
    for (int end = min(32 * word + 32, count); k < end; ++k) {
      NearSphere near = near_sphere(near_cells.x + k, center);
      uint bit = 1u << (k & 31);
      if (near.sphere.w < 0.0) without_points |= bit;
      if (in_ball(near)) {
        NearTraits cell = near_traits_of(near_cells.x + k);
        bits |= bit;
        bool has_boundary = (cell.bits & CELL_AT_BOUNDARY) != 0;
#if OVER_LINKS
        if (has_boundary) boundary |= bit;
#else
        flat_area += cell.projected * part_in_ball(near);
        single = single && (cell.bits & CELL_FACES_CENTERS) != 0;
        if (single && has_boundary) single = !meets_boundary(cell.number, center);
#endif
      }
    }
    taken[word] = bits;
#if OVER_LINKS
    at_boundary[word] = boundary;
    leading[word] = without_points;
#endif
  }
  return single && flat_area < 1.25 * 3.14159265 * params.radius * params.radius;
}
