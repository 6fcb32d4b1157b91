// Sweeps over the nodes alternately forward and backward, and then crosses dipping edges, until nothing more is reached.
#include "engine/cpu/point_flood.h"

namespace paradesc {

PointFlood::PointFlood(const PointPatches &patches, const PatchArrays &surface, const BallTarget &target)
    : patches_(patches), surface_(surface), target_(target), dipped_(patches.triangle.size(), 0),
      missed_(static_cast<size_t>(patches.patches()), 0), met_(missed_) {}

uint32_t PointFlood::run(const CenterLanes &centers, const FloodStart *starts, NearPatches &near) {
  for (int32_t i = 0; i < centers.count; ++i) {
    const auto [node, triangle] = starts[i];
    const uint32_t center = uint32_t{1} << i;
    if (node >= 0) {
      near.reached[node] = static_cast<uint16_t>(near.reached[node] | center);
      continue;
    }
    dip_into(triangle, center);
    for (int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
      uint16_t &reached = near.reached[patches_.corner[corner]];
      reached = static_cast<uint16_t>(reached | (center & near.in[patches_.corner[corner]]));
    }
  }
  bool borders = false, is_long = false;
  for (int32_t i = 0; i < near.patches; ++i) {
    const int32_t patch = near.patch[i].patch;
    borders = borders || patches_.edge_begin[patch] < patches_.edge_begin[patch + 1];
    is_long = is_long || surface_.has_long_edge[patch] != 0;
  }
  if (!spread(near) || borders || is_long)
    while (dip(centers, near)) spread(near);
  if (patches_.clusters() > 0) find_clusters(centers, near);
  return borders ? boundary(centers, near) : 0;
}

void PointFlood::forget() {
  for (const int32_t triangle : dipped_triangles_) dipped_[triangle] = 0;
  dipped_triangles_.clear();
}

void PointFlood::dip_into(int32_t triangle, uint32_t centers) {
  if (dipped_[triangle] == 0) dipped_triangles_.push_back(triangle);
  dipped_[triangle] = static_cast<uint16_t>(dipped_[triangle] | centers);
}

// Returns the set of centers from which any adjacent node is reached.
uint32_t PointFlood::around(const NearPatches &near, int32_t node) const {
  constexpr auto room = static_cast<size_t>(PointPatches::near_neighbors);
  uint32_t reached = 0;
  const int32_t *const neighbor = &patches_.neighbor[room * static_cast<size_t>(node)];
  for (size_t k = 0; k < room; ++k) reached |= near.reached[neighbor[k]];
  for (int32_t k = patches_.more_begin[node]; k < patches_.more_begin[node + 1]; ++k) reached |= near.reached[patches_.more[k]];
  return reached;
}

// Returns whether all nodes in the balls are reached.
bool PointFlood::spread(NearPatches &near) const {
  bool more = true, all = false;
  const auto visit = [&](int32_t node) {
    const uint32_t in = near.in[node], had = near.reached[node];
    if (in == had) return;
    const uint32_t reached = had | (around(near, node) & in);
    near.reached[node] = static_cast<uint16_t>(reached);
    more |= reached != had;
    all &= (in & ~reached) == 0;
  };
  for (bool forward = true; more && !all; forward = !forward) {
    more = false;
    all = true;
    if (forward)
      for (int32_t i = 0; i < near.nodes; ++i) visit(near.node[i]);
    else
      for (int32_t i = near.nodes; i-- > 0;) visit(near.node[i]);
  }
  return all;
}

// A cluster that the rim cuts is reached if it is beside a node that is reached.
void PointFlood::find_clusters(const CenterLanes &centers, NearPatches &near) const {
  for (int32_t i = 0; i < near.patches; ++i) {
    const int32_t patch = near.patch[i].patch;
    for (int32_t k = patches_.cluster_begin[patch]; k < patches_.cluster_begin[patch + 1]; ++k) {
      const int32_t node = patches_.cluster_node[k];
      const float middle[3] = {surface_.position[0][node], surface_.position[1][node], surface_.position[2][node]};
      const auto [within, touched] = target_.sphere(centers, middle, surface_.node_reach[node]);
      const uint32_t whole = within & near.reached[node];
      near.whole[k] = static_cast<uint16_t>(whole);
      near.part[k] = static_cast<uint16_t>((near.reached[node] | around(near, node)) & touched & ~whole & centers.all());
    }
  }
}

// Finds patches that, together with adjacent ones, have both reached and missing points in some ball, patches at the boundary,
// and patches with long edges.
void PointFlood::find_open(const NearPatches &near) {
  open_.clear();
  for (int32_t i = 0; i < near.patches; ++i) {
    const int32_t patch = near.patch[i].patch;
    uint32_t missed = 0, met = 0;
    for (int32_t node = patches_.patch_begin[patch]; node < patches_.patch_begin[patch + 1]; ++node) {
      missed |= near.in[node] & ~uint32_t{near.reached[node]};
      met |= near.reached[node];
    }
    missed_[patch] = static_cast<uint16_t>(missed);
    met_[patch] = static_cast<uint16_t>(met);
  }
  for (const int32_t triangle : dipped_triangles_) met_[patches_.patch_of[patches_.corner[3 * triangle]]] |= dipped_[triangle];
  for (int32_t i = 0; i < near.patches; ++i) {
    const int32_t patch = near.patch[i].patch;
    uint32_t missed = missed_[patch], met = met_[patch];
    for (int32_t k = patches_.link_begin[patch]; k < patches_.link_begin[patch + 1]; ++k) {
      missed |= missed_[patches_.link[k]];
      met |= met_[patches_.link[k]];
    }
    const bool borders = patches_.edge_begin[patch] < patches_.edge_begin[patch + 1];
    if ((missed & met) != 0 || borders || surface_.has_long_edge[patch] != 0) open_.push_back(patch);
  }
  for (int32_t i = 0; i < near.patches; ++i) missed_[near.patch[i].patch] = met_[near.patch[i].patch] = 0;
  for (const int32_t triangle : dipped_triangles_) met_[patches_.patch_of[patches_.corner[3 * triangle]]] = 0;
}

// Continues across edges that dip into balls. Returns whether that reached anything new.
bool PointFlood::dip(const CenterLanes &centers, NearPatches &near) {
  find_open(near);
  bool found = false;
  for (const int32_t patch : open_)
    for (int32_t t = patches_.triangle_begin[patch]; t < patches_.triangle_begin[patch + 1]; ++t) {
      const int32_t *const corner = &patches_.corner[3 * t];
      const uint32_t dipped = dipped_[t],
                     reached[3] = {near.reached[corner[0]], near.reached[corner[1]], near.reached[corner[2]]};
      if ((dipped | reached[0] | reached[1] | reached[2]) == 0) continue;
      const uint32_t in[3] = {near.in[corner[0]], near.in[corner[1]], near.in[corner[2]]};
      for (int k = 0; k < 3; ++k) {
        const uint32_t open = (reached[(k + 2) % 3] | dipped) & ~in[k] & ~in[(k + 1) % 3];
        if (open != 0 && dip_over(centers, near, 3 * t + k, open)) found = true;
      }
    }
  return found;
}

static int32_t next_in_triangle(int32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

// open: the centers that reach the triangle of the half-edge, but neither of its ends.
bool PointFlood::dip_over(const CenterLanes &centers, NearPatches &near, int32_t half_edge, uint32_t open) {
  const int32_t twin = patches_.twin[half_edge];
  if (twin < 0) return false;
  const int32_t behind = patches_.corner[next_in_triangle(next_in_triangle(twin))], triangle = twin / 3;
  open &= ~uint32_t{near.reached[behind]} & ~uint32_t{dipped_[triangle]};
  if (open == 0) return false;
  const uint32_t over = open &
                        target_.dips(surface_, centers, patches_.corner[half_edge], patches_.corner[next_in_triangle(half_edge)]),
                 in = over & near.in[behind];
  near.reached[behind] = static_cast<uint16_t>(near.reached[behind] | in);
  if ((over & ~in) != 0) dip_into(triangle, over & ~in);
  return over != 0;
}

uint32_t PointFlood::boundary(const CenterLanes &centers, const NearPatches &near) const {
  uint32_t found = 0;
  for (int32_t i = 0; i < near.patches; ++i)
    for (int32_t k = patches_.edge_begin[near.patch[i].patch]; k < patches_.edge_begin[near.patch[i].patch + 1]; ++k) {
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
