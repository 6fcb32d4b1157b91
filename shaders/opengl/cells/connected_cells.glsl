// Follows links within the center's ball from its start cells → the taken cells that are connected to the center there.
//
// Cells are numbered by their place in the list of cells near the center.
#include "opengl/cells/near_list.glsl"
layout(binding = UNIT_NEAR_NEIGHBORS) uniform isamplerBuffer near_neighbors;
layout(binding = UNIT_LINK_POINTS) uniform samplerBuffer link_points;
layout(binding = UNIT_LINK_SPHERES) uniform samplerBuffer link_spheres;

// One bit per cell: it was reached; its neighbors have not been visited yet.
uint reached[NEAR_WORDS], pending[NEAR_WORDS];
int missing; // taken cells that are not reached

bool is_taken(int k) { return (taken[k >> 5] >> (k & 31) & 1u) != 0u; }
bool leads_on(int k) { return (leading[k >> 5] >> (k & 31) & 1u) != 0u; }
bool was_reached(int k) { return (reached[k >> 5] >> (k & 31) & 1u) != 0u; }

void reach(int k) {
  uint bit = 1u << (k & 31);
  if ((reached[k >> 5] & bit) != 0u) return;
  reached[k >> 5] |= bit;
  pending[k >> 5] |= bit;
  if (is_taken(k)) --missing;
}

// Returns whether a boundary edge of the mesh that a taken cell touches meets the ball.
bool boundary_meets(vec3 center, ivec2 near_cells) {
  bool boundary = false;
  for (int word = 0; word < NEAR_WORDS; ++word)
    for (uint left = taken[word] & at_boundary[word]; left != 0u && !boundary; left &= left - 1u)
      boundary = meets_boundary(near_traits_of(near_cells.x + 32 * word + findLSB(left)).number, center);
  return boundary;
}

// Drops cells that are not connected. A neighbor outside the ball adds nothing and leads to nothing inside, unless it has no
// texels. There is one loop instead of nested ones, which would run as often as the longest among neighboring invocations in
// each turn. Each turn tests one point of a link, moves to a cell's next neighbor, or finds the next cell.
void keep_connected(vec3 center, ivec2 starts, ivec2 near_cells) {
  missing = 0;
  for (int i = 0; i < NEAR_WORDS; ++i) {
    reached[i] = pending[i] = 0u;
    missing += bitCount(taken[i]);
  }
  for (int i = starts.x; i < starts.y; ++i) {
    int k = place_of(texelFetch(start_cells, i).x, near_cells);
    if (k >= 0) reach(k);
  }
  bool within = false; // the whole cell and its links lie in the ball
  ivec2 neighbors = ivec2(0), points = ivec2(0);
  int word = 0, idle = 0, beyond = 0;
  for (int turn = 0; turn < MAX_ITERATIONS && missing > 0; ++turn) {
    if (points.x < points.y) {
      if (in_ball(texelFetch(link_points, 2 * points.x).xyz, center)) {
        reach(beyond);
        points.x = points.y;
      }
      ++points.x;
    } else if (neighbors.x < neighbors.y) {
      ivec4 neighbor = texelFetch(near_neighbors, neighbors.x++);
      beyond = neighbor.x;
      if (beyond >= 0 && !was_reached(beyond) && (is_taken(beyond) || leads_on(beyond))) {
        vec4 sphere = texelFetch(link_spheres, neighbor.y);
        float away = length(sphere.xyz - center);
        if (within || away + sphere.w < params.radius)
          reach(beyond);
        else if (away - sphere.w < params.radius)
          points = neighbor.zw;
      }
    } else if (pending[word] == 0u) {
      word = (word + 1) % NEAR_WORDS;
      if (++idle > NEAR_WORDS) break;
    } else {
      int bit = findLSB(pending[word]), entry = near_cells.x + 32 * word + bit;
      pending[word] &= ~(1u << bit);
      idle = 0;
      within = within_ball(near_sphere(entry, center));
      neighbors = texelFetch(near_traits, NEAR_TRAITS * entry + 2).xy;
    }
  }
  for (int i = 0; i < NEAR_WORDS; ++i) taken[i] &= reached[i];
}
