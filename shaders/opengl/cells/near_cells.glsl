// The cells near a center: which of them lie in its ball, and whether these form a single sheet of surface.
layout(binding = UNIT_CELL_LISTS) uniform isamplerBuffer cell_lists;
layout(binding = UNIT_NEAR_SPHERES) uniform samplerBuffer near_spheres;
layout(binding = UNIT_NEAR_TRAITS) uniform isamplerBuffer near_traits;
layout(binding = UNIT_BOUNDARY) uniform samplerBuffer boundary_ends;
layout(binding = UNIT_STARTS) uniform isamplerBuffer start_ranges;
layout(binding = UNIT_START_CELLS) uniform isamplerBuffer start_cells;
layout(location = LOCATION_RANGES) uniform int ranges_of_center; // at most

// A near cell relative to the center.
struct NearSphere {
  vec4 sphere;
  float square; // squared distance of its middle
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
  float projected;  // area of its projection
  float unit;       // of its leaves' codes
};

NearTraits near_traits_of(int entry) {
  ivec4 traits = texelFetch(near_traits, NEAR_TRAITS * entry);
  return NearTraits(traits.x, traits.y, intBitsToFloat(traits.z), intBitsToFloat(traits.w));
}

bool in_ball(vec3 point, vec3 center) {
  vec3 gap = point - center;
  return dot(gap, gap) < params.radius * params.radius;
}

// Returns whether a boundary edge of the mesh meets the ball.
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

// The share of a cell's area that counts: it falls from 1 at r^2 - 2 r s to 0 at r^2 + 2 r s, so that a flat disk keeps its area.
float part_in_ball(NearSphere near) {
  float radius = params.radius, across = near.sphere.w;
  return clamp((radius * (radius + 2.0 * across) - near.square) / max(4.0 * radius * across, 1e-30), 0.0, 1.0);
}

// One bit per cell near the center, in the order of the list: the cell lies in the ball and belongs to the neighborhood. For
// centers that follow links: a boundary edge of the mesh runs through the cell; the cell has no texels, but may lead on.
uint taken[NEAR_WORDS];
#if OVER_LINKS
uint at_boundary[NEAR_WORDS], leading[NEAR_WORDS];
#endif

// Takes the cells in the ball. all_connected: all cells near the center are connected. Returns whether the cells in the ball all
// face the same way as the center and cover its tangent plane once: then they are connected. OVER_LINKS: known to be false.
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
