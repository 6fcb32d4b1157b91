// Creases by cells of a grid as wide as they reach.
#include "engine/creases/near.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/limits.h"
#include "mesh/ball_flood.h"

namespace paradesc {

constexpr double last_cell = (1 << 21) - 1; // along a side

NearCreases::NearCreases(const CreasedSurface &surface, double radius)
    : surface_(surface), radius_(radius), cell_(CREASE_REACH * radius) {
  const std::vector<int32_t> &edges = surface.creases.edges;
  dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (const int32_t edge : edges)
    for (const int32_t corner : {edge, next_corner(edge)}) {
      low = glm::min(low, dvec3(surface.triangles.position(corner)));
      high = glm::max(high, dvec3(surface.triangles.position(corner)));
    }
  constexpr double most_cells = 128; // along a side: creases may be long against the radius
  constexpr double above_0 = std::numeric_limits<double>::min(); // of surfaces that are one point
  cell_ = std::max({cell_, glm::length(high - low) / most_cells, above_0});
  low_ = low - 2.0 * cell_;
  for (const int32_t edge : edges) add_edge(edge);
  std::sort(edges_.begin(), edges_.end());
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
}

// Three whole numbers.
dvec3 NearCreases::cell_at(dvec3 position) const { return glm::clamp(glm::floor((position - low_) / cell_), 0.0, last_cell); }

static uint64_t number_of(dvec3 cell) {
  return (static_cast<uint64_t>(cell.x) << 42) | (static_cast<uint64_t>(cell.y) << 21) | static_cast<uint64_t>(cell.z);
}

// To all cells within reach of it, piece by piece.
void NearCreases::add_edge(int32_t edge) {
  const double reach = CREASE_REACH * radius_;
  const dvec3 begin(surface_.triangles.position(edge)), way = dvec3(surface_.triangles.position(next_corner(edge))) - begin;
  const int pieces = 1 + static_cast<int>(glm::length(way) / cell_);
  for (int i = 0; i < pieces; ++i) {
    const dvec3 a = begin + way * (static_cast<double>(i) / pieces), b = begin + way * (static_cast<double>(i + 1) / pieces);
    const dvec3 low = cell_at(glm::min(a, b) - reach), high = cell_at(glm::max(a, b) + reach);
    for (double x = low.x; x <= high.x; ++x)
      for (double y = low.y; y <= high.y; ++y)
        for (double z = low.z; z <= high.z; ++z) edges_.push_back({number_of({x, y, z}), edge});
  }
}

bool NearCreases::reach(dvec3 position, int32_t triangle) const {
  const std::vector<int32_t> &piece = surface_.half_edges.triangle_piece;
  const uint64_t cell = number_of(cell_at(position));
  const auto from_here = [&](int32_t corner) { return dvec3(surface_.triangles.position(corner)) - position; };
  for (auto item = std::lower_bound(edges_.begin(), edges_.end(), Edge{cell, -1}); item != edges_.end() && item->cell == cell;
       ++item)
    if (piece[item->edge / 3] == piece[triangle] &&
        segment_distance(from_here(item->edge), from_here(next_corner(item->edge))) < CREASE_REACH * radius_)
      return true;
  return false;
}

} // namespace paradesc
