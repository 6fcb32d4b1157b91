// Sweeps over the nodes alternately forward and backward, and then crosses dipping edges, until nothing more is reached.
#include "engine/cpu/point_flood.h"

namespace paradesc {

static constexpr uint32_t never = ~uint32_t{0}, all_centers = (uint32_t{1} << group_lanes) - 1;

PointFlood::PointFlood(const PointPatches &patches, const PatchArrays &surface, const BallTarget &target)
    : patches_(patches), surface_(surface), target_(target), dipped_(patches.triangle.size(), 0),
      state_(static_cast<size_t>(patches.patches()), PatchState{never, never, 0, 0}) {}

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
  for (int32_t i = 0; i < near.patches; ++i) state_[near.patch[i].patch] = {never, never, 0, 0};
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

// Finds for each patch the balls in which its points are reached and not reached, and whether more is reached than before.
void PointFlood::look_at_patches(const NearPatches &near) {
  for (int32_t i = 0; i < near.patches; ++i) {
    const int32_t patch = near.patch[i].patch;
    uint32_t missed = 0, met = 0, reached = 0;
    for (int32_t node = patches_.patch_begin[patch]; node < patches_.patch_begin[patch + 1]; ++node) {
      missed |= near.in[node] & ~uint32_t{near.reached[node]};
      met |= near.reached[node];
      reached += near.reached[node];
    }
    state_[patch] = {reached, state_[patch].reached, static_cast<uint16_t>(missed), static_cast<uint16_t>(met)};
  }
  for (const int32_t triangle : dipped_triangles_) {
    PatchState &state = state_[patches_.patch_of[patches_.corner[3 * triangle]]];
    state.met |= dipped_[triangle];
    state.reached += dipped_[triangle];
  }
}

// Finds patches that, together with adjacent ones, have both reached and missing points in some ball, patches at the boundary,
// and patches with long edges, unless nothing has changed there since edges were last looked at.
void PointFlood::find_open(const NearPatches &near) {
  open_.clear();
  for (int32_t i = 0; i < near.patches; ++i) {
    const int32_t patch = near.patch[i].patch;
    uint32_t missed = state_[patch].missed, met = state_[patch].met;
    bool has_changed = state_[patch].has_changed();
    for (int32_t k = patches_.link_begin[patch]; k < patches_.link_begin[patch + 1]; ++k) {
      const PatchState &linked = state_[patches_.link[k]];
      missed |= linked.missed;
      met |= linked.met;
      has_changed = has_changed || linked.has_changed();
    }
    if (!has_changed) continue;
    const bool borders = patches_.edge_begin[patch] < patches_.edge_begin[patch + 1];
    const uint32_t centers = borders || surface_.has_long_edge[patch] != 0 ? all_centers : missed & met;
    if (centers != 0) open_.push_back({patch, centers});
  }
}

// Lists the edges with both ends outside balls from which a triangle beside them is reached, and returns their number.
int32_t PointFlood::list_edges(const NearPatches &near) {
  size_t count = 0;
  for (const auto [patch, centers] : open_) {
    const int32_t begin = patches_.triangle_begin[patch], end = patches_.triangle_begin[patch + 1];
    if (const size_t room = count + 3 * static_cast<size_t>(end - begin); edges_.size() < room) edges_.resize(2 * room);
    for (int32_t t = begin; t < end; ++t) {
      const int32_t *const corner = &patches_.corner[3 * t];
      const uint32_t dipped = dipped_[t];
      for (int32_t k = 0; k < 3; ++k) { // without branches, since which triangles the rim cuts is unpredictable
        const int32_t from = corner[k], to = corner[(k + 1) % 3];
        const uint32_t reached = near.reached[corner[(k + 2) % 3]] | dipped;
        edges_[count] = {3 * t + k, from, to, reached & ~uint32_t{near.in[from]} & ~uint32_t{near.in[to]} & centers};
        count += edges_[count].centers != 0;
      }
    }
  }
  return static_cast<int32_t>(count);
}

// Continues across edges that dip into balls. Returns whether that reached anything new.
bool PointFlood::dip(const CenterLanes &centers, NearPatches &near) {
  look_at_patches(near);
  find_open(near);
  const int32_t listed = list_edges(near), dipping = target_.dips(surface_, centers, edges_.data(), listed);
  bool found = false;
  for (int32_t i = 0; i < dipping; ++i) found |= go_over(near, edges_[static_cast<size_t>(i)]);
  return found;
}

static int32_t next_in_triangle(int32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

// Reaches the triangle across an edge. Returns whether it was not reached from some of the edge's centers.
bool PointFlood::go_over(NearPatches &near, const OpenEdge &edge) {
  const int32_t twin = patches_.twin[edge.half_edge];
  if (twin < 0) return false;
  const int32_t behind = patches_.corner[next_in_triangle(next_in_triangle(twin))], triangle = twin / 3;
  const uint32_t over = edge.centers & ~uint32_t{near.reached[behind]} & ~uint32_t{dipped_[triangle]},
                 in = over & near.in[behind];
  near.reached[behind] = static_cast<uint16_t>(near.reached[behind] | in);
  if ((over & ~in) != 0) dip_into(triangle, over & ~in);
  return over != 0;
}

uint32_t PointFlood::boundary(const CenterLanes &centers, const NearPatches &near) {
  uint32_t found = 0;
  size_t open = 0;
  for (int32_t i = 0; i < near.patches; ++i)
    for (int32_t k = patches_.edge_begin[near.patch[i].patch]; k < patches_.edge_begin[near.patch[i].patch + 1]; ++k) {
      const int32_t edge = patches_.edge[k], next = next_in_triangle(edge), from = patches_.corner[edge],
                    to = patches_.corner[next];
      found |= near.reached[from] | uint32_t{near.reached[to]};
      const uint32_t reached = near.reached[patches_.corner[next_in_triangle(next)]] | uint32_t{dipped_[edge / 3]};
      if (open == edges_.size()) edges_.resize(2 * open + 64);
      edges_[open] = {edge, from, to, reached & ~uint32_t{near.in[from]} & ~uint32_t{near.in[to]}};
      open += edges_[open].centers != 0;
    }
  const int32_t dipping = target_.dips(surface_, centers, edges_.data(), static_cast<int32_t>(open));
  for (int32_t i = 0; i < dipping; ++i) found |= edges_[static_cast<size_t>(i)].centers;
  return found;
}

} // namespace paradesc
