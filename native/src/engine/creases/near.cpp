// Stores creases in grids, one per component, with cells as wide as the creases' reach. A place only sees those of its own
// component.
#include "engine/creases/near.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/limits.h"

namespace paradesc {

static constexpr double most_cells = 128; // along a side; limits the grid if creases are long compared with the radius

static uint64_t number_of(dvec3 cell) {
  return (static_cast<uint64_t>(cell.x) << 16) | (static_cast<uint64_t>(cell.y) << 8) | static_cast<uint64_t>(cell.z);
}

NearCreases::NearCreases(const CreasedSurface &surface, double radius) : surface_(surface), radius_(radius) {
  const std::vector<int32_t> &piece = surface.half_edges.triangle_piece;
  std::vector<int32_t> edges = surface.creases.edges;
  std::ranges::stable_sort(edges, {}, [&](int32_t edge) { return piece[edge / 3]; });
  grids_.resize(edges.empty() ? 0 : static_cast<size_t>(piece[edges.back() / 3]) + 1);
  for (size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    const int32_t own = piece[edges[begin] / 3];
    while (end < edges.size() && piece[edges[end] / 3] == own) ++end;
    if (own >= 0) fill(grids_[own], edges, begin, end);
  }
}

void NearCreases::fill(Grid &grid, const std::vector<int32_t> &edges, size_t begin, size_t end) {
  constexpr double above_0 = std::numeric_limits<double>::min(); // for surfaces that are a single point
  for (size_t i = begin; i < end; ++i)
    for (const int32_t corner : {edges[i], next_corner(edges[i])}) grid.add(dvec3(surface_.triangles.position(corner)));
  grid.cell = std::max({CREASE_REACH * radius_, glm::length(grid.size()) / most_cells, above_0});
  grid.begin = entries_.size();
  for (size_t i = begin; i < end; ++i) add_edge(grid, edges[i]);
  const auto first = entries_.begin() + static_cast<ptrdiff_t>(grid.begin);
  std::sort(first, entries_.end());
  entries_.erase(std::unique(first, entries_.end()), entries_.end());
  grid.end = entries_.size();
}

// Adds an edge to all cells within reach of it, piece by piece. The grid ends where creases do: cell_at() clamps a place beyond
// to the nearest cell, which is at least as near to every crease.
void NearCreases::add_edge(const Grid &grid, int32_t edge) {
  const double reach = CREASE_REACH * radius_;
  const dvec3 begin(surface_.triangles.position(edge)), way = dvec3(surface_.triangles.position(next_corner(edge))) - begin;
  const int pieces = 1 + static_cast<int>(glm::length(way) / grid.cell);
  for (int i = 0; i < pieces; ++i) {
    const dvec3 a = begin + way * (static_cast<double>(i) / pieces), b = begin + way * (static_cast<double>(i + 1) / pieces);
    const dvec3 low = grid.cell_at(glm::min(a, b) - reach), high = grid.cell_at(glm::max(a, b) + reach);
    for (double x = low.x; x <= high.x; ++x)
      for (double y = low.y; y <= high.y; ++y)
        for (double z = low.z; z <= high.z; ++z) entries_.push_back((number_of({x, y, z}) << 32) | static_cast<uint32_t>(edge));
  }
}

void NearCreases::find(dvec3 position, int32_t triangle, std::vector<NearCrease> &found) const {
  found.clear();
  const auto piece = static_cast<size_t>(surface_.half_edges.triangle_piece[triangle]);
  if (piece >= grids_.size() || grids_[piece].begin == grids_[piece].end) return;
  const Grid &grid = grids_[piece];
  const double reach = CREASE_REACH * radius_;
  const dvec3 beyond = glm::abs(position - glm::clamp(position, grid.low, grid.high));
  if (std::max({beyond.x, beyond.y, beyond.z}) > reach) return;
  const uint64_t cell = number_of(grid.cell_at(position));
  const auto from_here = [&](int32_t corner) { return dvec3(surface_.triangles.position(corner)) - position; };
  const auto end = entries_.begin() + static_cast<ptrdiff_t>(grid.end);
  for (auto item = std::lower_bound(entries_.begin() + static_cast<ptrdiff_t>(grid.begin), end, cell << 32);
       item != end && *item >> 32 == cell; ++item) {
    const auto edge = static_cast<int32_t>(*item & 0xffffffff);
    const double square = segment_distance2(from_here(edge), from_here(next_corner(edge)));
    if (square < reach * reach) found.push_back({std::sqrt(square), edge});
  }
}

} // namespace paradesc
