// Triangles → pairs of half-edges, the two sides of an edge: by vertex first, then by place.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/copies.h"
#include "mesh/triangles.h"
#include "mesh/weld.h"
#include "support/cancel.h"

namespace paradesc {

struct Pairing {
  std::vector<int32_t> twin;        // (3 * triangle_count) -1: none
  std::vector<uint8_t> nonmanifold; // (3 * triangle_count) 1: a side of an edge that was taken apart
  std::vector<int32_t> open;        // half-edges that have no twin and were not taken apart
  int nonmanifold_edges = 0;
  int opposed_edges = 0;   // nonmanifold edges along which all faces run the same way
  bool has_copies = false; // faces at the same three places meet at an edge, or the given copies are not empty
};

// Faces at the same three places are never paired with each other; each is paired with a face beside it. An edge between two
// faces that have n copies each gets n pairs. copies: from find_copies, or null to find out whether there are any.
Pairing pair_half_edges(const Triangles &triangles, const Places &places, const std::vector<uint8_t> &left_out,
                        const Copies *copies = nullptr);

// Calls visit(span of half-edges) once for each edge of the given half-edges; ids[corner] identifies their ends.
template <class Visit>
void for_each_edge(std::span<const int32_t> half_edges, const std::vector<int32_t> &ids, int id_count, const Visit &visit) {
  struct Side {
    int32_t high;
    int32_t half_edge;
  };
  const auto ends = [&](int32_t h) { return std::minmax(ids[h], ids[next_corner(h)]); };
  std::vector<int32_t> begin(size_t{2} + id_count, 0);
  for (int32_t h : half_edges) ++begin[size_t{2} + ends(h).first];
  checkpoint();
  for (size_t i = 2; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<Side> sides(half_edges.size());
  checkpoint();
  for (size_t i = 0; i < half_edges.size(); ++i) {
    checkpoint_at(i);
    const auto [low, high] = ends(half_edges[i]);
    sides[begin[size_t{1} + low]++] = {high, half_edges[i]};
  }
  std::vector<int32_t> edge;
  for (int32_t low = 0; low < id_count; ++low) {
    checkpoint_at(low);
    const std::span<Side> bucket(sides.begin() + begin[low], sides.begin() + begin[low + 1]);
    std::ranges::sort(bucket, [](Side a, Side b) { return a.high != b.high ? a.high < b.high : a.half_edge < b.half_edge; });
    for (size_t i = 0; i < bucket.size();) {
      const int32_t high = bucket[i].high;
      for (edge.clear(); i < bucket.size() && bucket[i].high == high; ++i) edge.push_back(bucket[i].half_edge);
      visit(std::span<const int32_t>(edge));
    }
  }
}

} // namespace paradesc
