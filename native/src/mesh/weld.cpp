// A hash table of positions, and a hash table of grid cells for positions that are nearly equal.
#include "mesh/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "support/cancel.h"

namespace paradesc {
namespace {

constexpr float rounding = 16 * std::numeric_limits<float>::epsilon(); // of the largest coordinate
constexpr float of_edge = 0.01f;

uint64_t mixed(uint64_t h, uint32_t bits) {
  h = (h ^ bits) * 0x9e3779b97f4a7c15u;
  return h ^ h >> 29;
}

uint64_t hash(const vec3 &p) {
  uint64_t h = 0;
  for (int i = 0; i < 3; ++i) h = mixed(h, std::bit_cast<uint32_t>(p[i] + 0.0f)); // adding zero makes -0 and 0 one
  return h;
}

void find_corners(const Triangles &triangles, Places &places) {
  places.of_corner.resize(triangles.corner_vertex.size());
  for (size_t corner = 0; corner < places.of_corner.size(); ++corner) {
    checkpoint_at(corner);
    places.of_corner[corner] = places.of_vertex[triangles.corner_vertex[corner]];
  }
}

// A grid of the places that are kept; finds the nearest within reach. A search visits one or two cells along each axis.
class Grid {
public:
  Grid(const std::vector<vec3> &positions, const std::vector<float> &reach, size_t places, float most)
      : positions_(positions), reach_(reach), cell_(4 * most), most_(most), table_(std::bit_ceil(2 * places), -1) {}

  // Returns -1 if none is within reach.
  int32_t nearest(int32_t place) const {
    const vec3 &p = positions_[place];
    const Cell low = cell_of(p - most_), high = cell_of(p + most_);
    int32_t found = -1;
    float least = reach_[place];
    for (int32_t x = low[0]; x <= high[0]; ++x)
      for (int32_t y = low[1]; y <= high[1]; ++y)
        for (int32_t z = low[2]; z <= high[2]; ++z)
          for (size_t slot = slot_of({x, y, z}); table_[slot] >= 0; slot = (slot + 1) & (table_.size() - 1)) {
            const int32_t other = table_[slot];
            const vec3 away = glm::abs(positions_[other] - p);
            const float distance = std::max({away.x, away.y, away.z});
            if (distance > std::min(least, reach_[other]) || (distance == least && found >= 0 && found <= other)) continue;
            found = other;
            least = distance;
          }
    return found;
  }

  void insert(int32_t place) {
    size_t slot = slot_of(cell_of(positions_[place]));
    while (table_[slot] >= 0) slot = (slot + 1) & (table_.size() - 1);
    table_[slot] = place;
  }

private:
  using Cell = std::array<int32_t, 3>;

  Cell cell_of(const vec3 &p) const {
    Cell cell;
    for (int i = 0; i < 3; ++i) cell[static_cast<size_t>(i)] = static_cast<int32_t>(std::floor(p[i] / cell_));
    return cell;
  }
  size_t slot_of(const Cell &cell) const {
    uint64_t h = 0;
    for (const int32_t index : cell) h = mixed(h, static_cast<uint32_t>(index));
    return h & (table_.size() - 1);
  }

  const std::vector<vec3> &positions_;
  const std::vector<float> &reach_;
  float cell_, most_;
  std::vector<int32_t> table_;
};

// The places at the ends of open edges, and the distance up to which each may be merged with another.
class Rims {
public:
  Rims(const Triangles &triangles, const Places &places)
      : positions_(triangles.positions), ids_(places.ids(triangles)), reach_(positions_.size(), none) {}

  void add(int32_t half_edge) {
    for (const int32_t place : {ids_[half_edge], ids_[next_corner(half_edge)]}) {
      if (reach_[place] == none) places_.push_back(place);
      reach_[place] = std::numeric_limits<float>::max();
      const vec3 size = glm::abs(positions_[place]);
      most_ = std::max({most_, rounding * size.x, rounding * size.y, rounding * size.z});
    }
    spare(half_edge);
  }

  // Keeps the ends of this half-edge apart, if they are ends of open edges.
  void spare(int32_t half_edge) {
    const int32_t a = ids_[half_edge], b = ids_[next_corner(half_edge)];
    if (reach_[a] == none && reach_[b] == none) return;
    const float least = of_edge * glm::length(positions_[b] - positions_[a]);
    reach_[a] = std::min(reach_[a], least);
    reach_[b] = std::min(reach_[b], least);
  }

  // Merges places; returns whether any were merged.
  bool join() {
    if (!(most_ > 0)) return false;
    std::ranges::sort(places_);
    for (const int32_t place : places_) reach_[place] = std::min(reach_[place], most_);
    Grid grid(positions_, reach_, places_.size(), most_);
    kept_.assign(positions_.size(), -1);
    bool any = false;
    for (size_t i = 0; i < places_.size(); ++i) {
      checkpoint_at(i);
      int32_t &kept = kept_[places_[i]];
      kept = grid.nearest(places_[i]);
      if (kept < 0) grid.insert(places_[i]);
      any = any || kept >= 0;
    }
    return any;
  }

  int32_t joined(int32_t place) const { return kept_[place] < 0 ? place : kept_[place]; }

private:
  static constexpr float none = -1; // no end of an open edge
  const std::vector<vec3> &positions_;
  const std::vector<int32_t> &ids_;
  std::vector<float> reach_;
  std::vector<int32_t> places_, kept_;
  float most_ = 0;
};

} // namespace

Places weld(const Triangles &triangles) {
  const std::vector<vec3> &positions = triangles.positions;
  const size_t slots = std::bit_ceil(2 * positions.size());
  std::vector<int32_t> table(slots, -1);
  Places places;
  places.of_vertex.resize(positions.size());
  bool shared = false;
  for (size_t vertex = 0; vertex < positions.size(); ++vertex) {
    checkpoint_at(vertex);
    size_t slot = hash(positions[vertex]) & (slots - 1);
    while (table[slot] >= 0 && positions[table[slot]] != positions[vertex]) slot = (slot + 1) & (slots - 1);
    if (table[slot] < 0)
      table[slot] = static_cast<int32_t>(vertex);
    else
      shared = true;
    places.of_vertex[vertex] = table[slot];
  }
  if (shared) find_corners(triangles, places);
  return places;
}

bool weld_rims(const Triangles &triangles, const std::vector<uint8_t> &left_out, std::span<const int32_t> open, Places &places) {
  if (open.empty()) return false;
  Rims rims(triangles, places);
  for (size_t i = 0; i < open.size(); ++i) {
    checkpoint_at(i);
    rims.add(open[i]);
  }
  if (!rims.join()) return false;
  for (int32_t h = 0; h < 3 * triangles.triangle_count; ++h) {
    checkpoint_at(h);
    if (!left_out[h / 3]) rims.spare(h);
  }
  if (!rims.join()) return false;
  for (int32_t &place : places.of_vertex) place = rims.joined(place);
  find_corners(triangles, places);
  return true;
}

} // namespace paradesc
