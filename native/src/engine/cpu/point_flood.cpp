// Sweeps over the points alternately forward and backward, and then crosses dipping edges, until nothing more is reached.
#include "engine/cpu/point_flood.h"

namespace paradesc {

PointFlood::PointFlood(const PointPatches &patches, const PatchArrays &surface, const BallTarget &target)
    : patches_(patches), surface_(surface), target_(target), dipped_(patches.triangle.size(), 0),
      missed_(static_cast<size_t>(patches.patches()), 0), met_(missed_) {}

uint32_t PointFlood::run(const CenterLanes &centers, int32_t first, NearPatches &near) {
  for (int32_t i = 0; i < centers.count; ++i) near.reached[first + i] = static_cast<uint16_t>(1 << i);
  bool borders = false;
  for (int32_t i = 0; i < near.patches && !borders; ++i)
    borders = patches_.edge_begin[near.patch[i]] < patches_.edge_begin[near.patch[i] + 1];
  if (spread(near) && !borders) return 0;
  while (dip(centers, near)) spread(near);
  const uint32_t found = borders ? boundary(centers, near) : 0;
  for (const int32_t triangle : dipped_triangles_) dipped_[triangle] = 0;
  dipped_triangles_.clear();
  return found;
}

// Returns whether all points in the balls are reached.
bool PointFlood::spread(NearPatches &near) const {
  constexpr auto room = static_cast<size_t>(PointPatches::near_neighbors);
  bool more = true, all = false;
  const auto visit = [&](int32_t point) {
    const uint32_t in = near.in[point], had = near.reached[point];
    if (in == had) return;
    uint32_t reached = had;
    const int32_t *const neighbor = &patches_.neighbor[room * static_cast<size_t>(point)];
    for (size_t k = 0; k < room; ++k) reached |= near.reached[neighbor[k]];
    for (int32_t k = patches_.more_begin[point]; k < patches_.more_begin[point + 1]; ++k)
      reached |= near.reached[patches_.more[k]];
    reached &= in;
    near.reached[point] = static_cast<uint16_t>(reached);
    more |= reached != had;
    all &= reached == in;
  };
  for (bool forward = true; more && !all; forward = !forward) {
    more = false;
    all = true;
    if (forward)
      for (int32_t i = 0; i < near.points; ++i) visit(near.point[i]);
    else
      for (int32_t i = near.points; i-- > 0;) visit(near.point[i]);
  }
  return all;
}

// Finds patches that, together with adjacent ones, have both reached and missing points in some ball, and patches at the
// boundary.
void PointFlood::find_open(const NearPatches &near) {
  open_.clear();
  for (int32_t i = 0; i < near.patches; ++i) {
    const int32_t patch = near.patch[i];
    uint32_t missed = 0, met = 0;
    for (int32_t point = patches_.patch_begin[patch]; point < patches_.patch_begin[patch + 1]; ++point) {
      missed |= near.in[point] & ~uint32_t{near.reached[point]};
      met |= near.reached[point];
    }
    missed_[patch] = static_cast<uint16_t>(missed);
    met_[patch] = static_cast<uint16_t>(met);
  }
  for (const int32_t triangle : dipped_triangles_) met_[patches_.patch_of[patches_.corner[3 * triangle]]] |= dipped_[triangle];
  for (int32_t i = 0; i < near.patches; ++i) {
    const int32_t patch = near.patch[i];
    uint32_t missed = missed_[patch], met = met_[patch];
    for (int32_t k = patches_.link_begin[patch]; k < patches_.link_begin[patch + 1]; ++k) {
      missed |= missed_[patches_.link[k]];
      met |= met_[patches_.link[k]];
    }
    if ((missed & met) != 0 || patches_.edge_begin[patch] < patches_.edge_begin[patch + 1]) open_.push_back(patch);
  }
  for (int32_t i = 0; i < near.patches; ++i) missed_[near.patch[i]] = met_[near.patch[i]] = 0;
  for (const int32_t triangle : dipped_triangles_) met_[patches_.patch_of[patches_.corner[3 * triangle]]] = 0;
}

// Continues across edges that dip into balls. Returns whether that reached anything new.
bool PointFlood::dip(const CenterLanes &centers, NearPatches &near) {
  find_open(near);
  bool found = false;
  for (const int32_t patch : open_)
    for (int32_t corner = 3 * patches_.triangle_begin[patch]; corner < 3 * patches_.triangle_begin[patch + 1]; ++corner)
      if (dip_from(centers, near, corner)) found = true;
  return found;
}

static int32_t next_in_triangle(int32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

bool PointFlood::dip_from(const CenterLanes &centers, NearPatches &near, int32_t half_edge) {
  const int32_t twin = patches_.twin[half_edge];
  if (twin < 0) return false;
  const int32_t next = next_in_triangle(half_edge), from = patches_.corner[half_edge], to = patches_.corner[next],
                apex = patches_.corner[next_in_triangle(next)],
                behind = patches_.corner[next_in_triangle(next_in_triangle(twin))], triangle = twin / 3;
  const uint32_t open = (near.reached[apex] | uint32_t{dipped_[half_edge / 3]}) & ~uint32_t{near.in[from]} &
                        ~uint32_t{near.in[to]} & ~uint32_t{near.reached[behind]} & ~uint32_t{dipped_[triangle]};
  if (open == 0) return false;
  const uint32_t over = open & target_.dips(surface_, centers, from, to), in = over & near.in[behind];
  near.reached[behind] = static_cast<uint16_t>(near.reached[behind] | in);
  if ((over & ~in) != 0) {
    if (dipped_[triangle] == 0) dipped_triangles_.push_back(triangle);
    dipped_[triangle] = static_cast<uint16_t>(dipped_[triangle] | (over & ~in));
  }
  return over != 0;
}

uint32_t PointFlood::boundary(const CenterLanes &centers, const NearPatches &near) const {
  uint32_t found = 0;
  for (int32_t i = 0; i < near.patches; ++i)
    for (int32_t k = patches_.edge_begin[near.patch[i]]; k < patches_.edge_begin[near.patch[i] + 1]; ++k) {
      const int32_t edge = patches_.edge[k], next = next_in_triangle(edge), from = patches_.corner[edge],
                    to = patches_.corner[next];
      found |= near.reached[from] | uint32_t{near.reached[to]};
      const uint32_t open = (near.reached[patches_.corner[next_in_triangle(next)]] | uint32_t{dipped_[edge / 3]}) &
                            ~uint32_t{near.in[from]} & ~uint32_t{near.in[to]} & ~found;
      if (open != 0) found |= open & target_.dips(surface_, centers, from, to);
    }
  return found;
}

} // namespace paradesc
