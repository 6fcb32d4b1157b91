// Pairs edges of two faces at once. At edges of more faces, copies of faces are told apart, and what remains is taken apart.
#include "mesh/pairing.h"

#include <tuple>

namespace paradesc {
namespace {

class Pairer {
public:
  Pairer(const Triangles &triangles, const Places &places, const Copies *copies, Pairing &pairing)
      : places_(places.ids(triangles)), copies_(copies), pairing_(pairing) {}

  // Pairs all unambiguous half-edges and returns those that may have a twin at another vertex.
  std::vector<int32_t> pair_by(const std::vector<int32_t> &ids, int id_count, std::span<const int32_t> half_edges) {
    ids_ = &ids;
    thirds_of_ = copies_ ? &places_ : &ids; // while no copies are known, the ids are at hand
    std::vector<int32_t> alone;
    for_each_edge(half_edges, ids, id_count, [&](std::span<const int32_t> edge) {
      if (edge.size() == 1)
        alone.push_back(edge[0]);
      else if (edge.size() == 2 && opposite(edge[0], edge[1]) && third(edge[0]) != third(edge[1]))
        pair(edge[0], edge[1]);
      else if (!copies_)
        take_apart(edge);
      else
        pair_among_copies(edge, alone);
    });
    return alone;
  }

private:
  bool opposite(int32_t a, int32_t b) const { return (*ids_)[a] != (*ids_)[b]; } // they start at different ends
  int32_t third(int32_t h) const { return (*thirds_of_)[previous_corner(h)]; }   // tells copies apart

  void pair(int32_t a, int32_t b) {
    pairing_.twin[a] = b;
    pairing_.twin[b] = a;
  }

  void take_apart(std::span<const int32_t> edge) {
    ++pairing_.nonmanifold_edges;
    const auto along = [&](int32_t h) { return !opposite(h, edge[0]); };
    pairing_.opposed_edges += std::ranges::all_of(edge, along);
    for (const int32_t h : edge) pairing_.nonmanifold[h] = 1;
    if (pairing_.has_copies) return;
    thirds_.clear();
    for (const int32_t h : edge) thirds_.push_back(places_[previous_corner(h)]);
    std::ranges::sort(thirds_);
    pairing_.has_copies = std::ranges::adjacent_find(thirds_) != thirds_.end();
  }

  // Pairs the faces of an edge if they lie at two triples of places; takes the edge apart if there are more.
  void pair_among_copies(std::span<const int32_t> edge, std::vector<int32_t> &alone) {
    const int32_t first = copies_->group[edge[0] / 3];
    int32_t second = first;
    for (const int32_t h : edge) {
      const int32_t group = copies_->group[h / 3];
      if (second == first) second = group;
      if (group != first && group != second) return take_apart(edge);
    }
    // The order puts half-edges of one group and winding by rank, each next to its twin in the other group.
    const auto key = [&](int32_t h) {
      const bool is_first = copies_->group[h / 3] == first;
      return std::tuple(is_first == opposite(h, edge[0]), copies_->rank[h / 3], !is_first);
    };
    sorted_.assign(edge.begin(), edge.end());
    std::ranges::sort(sorted_, {}, key);
    bool paired = second == first; // true: there is nothing to pair
    for (size_t i = 1; i < sorted_.size(); ++i) {
      const auto [way, rank, is_second] = key(sorted_[i]);
      if (!is_second || key(sorted_[i - 1]) != std::tuple(way, rank, false)) continue;
      pair(sorted_[i - 1], sorted_[i]);
      paired = true;
    }
    if (!paired) return take_apart(edge);
    for (const int32_t h : edge)
      if (pairing_.twin[h] < 0) alone.push_back(h);
  }

  const std::vector<int32_t> &places_;
  const Copies *copies_;
  Pairing &pairing_;
  const std::vector<int32_t> *ids_ = nullptr, *thirds_of_ = nullptr;
  std::vector<int32_t> thirds_, sorted_;
};

} // namespace

Pairing pair_half_edges(const Triangles &triangles, const Places &places, const std::vector<uint8_t> &left_out,
                        const Copies *copies) {
  const int32_t count = 3 * triangles.triangle_count;
  Pairing pairing;
  pairing.twin.assign(count, -1);
  pairing.nonmanifold.assign(count, 0);
  pairing.has_copies = copies && !copies->groups.empty();
  checkpoint();
  std::vector<int32_t> used;
  used.reserve(count);
  for (int32_t h = 0; h < count; ++h) {
    checkpoint_at(h);
    if (!left_out[h / 3]) used.push_back(h);
  }
  Pairer pairer(triangles, places, copies, pairing);
  pairing.open = pairer.pair_by(triangles.corner_vertex, triangles.vertex_count, used);
  if (pairing.open.empty() || !places.are_shared()) return pairing;
  pairing.open = pairer.pair_by(places.of_corner, triangles.vertex_count, pairing.open);
  return pairing;
}

} // namespace paradesc
