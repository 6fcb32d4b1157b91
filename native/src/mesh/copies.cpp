// Sorts triangles by their places → groups of copies. Leaves out sheets whose triangles all have copies in better sheets.
#include "mesh/copies.h"

#include <algorithm>
#include <array>
#include <tuple>

#include "mesh/halfedge.h"
#include "support/cancel.h"

namespace paradesc {
namespace {

using Three = std::array<int32_t, 3>;

Three sorted_ids(const std::vector<int32_t> &ids, int32_t triangle) {
  Three three = {ids[3 * triangle], ids[3 * triangle + 1], ids[3 * triangle + 2]};
  std::ranges::sort(three);
  return three;
}

// Returns whether an even number of swaps sorts the ids of a triangle's corners.
bool is_even(const std::vector<int32_t> &ids, int32_t triangle) {
  const int32_t *id = &ids[3 * triangle];
  return (id[0] > id[1]) == ((id[1] > id[2]) != (id[0] > id[2]));
}

struct Member {
  Three places;
  int32_t triangle;
  auto operator<=>(const Member &) const = default;
};

void add_group(const std::vector<int32_t> &ids, std::vector<int32_t> group, Copies &copies) {
  std::array<int32_t, 2> count = {0, 0};
  for (const int32_t triangle : group) {
    copies.group[triangle] = group[0];
    copies.turned[triangle] = is_even(ids, triangle) != is_even(ids, group[0]);
    copies.rank[triangle] = count[copies.turned[triangle]]++;
  }
  copies.groups.push_back(std::move(group));
}

// (vertex_count) 1: the place belongs to several vertices.
std::vector<uint8_t> shared_places(const Places &places) {
  std::vector<uint8_t> is_shared(places.of_vertex.size(), 0);
  for (size_t vertex = 0; vertex < is_shared.size(); ++vertex) {
    checkpoint_at(vertex);
    if (const int32_t place = places.of_vertex[vertex]; place != static_cast<int32_t>(vertex)) is_shared[place] = 1;
  }
  return is_shared;
}

} // namespace

bool has_copies_of(const Triangles &triangles, const Places &places, const std::vector<uint8_t> &left_out,
                   std::span<const int32_t> half_edges) {
  if (half_edges.empty() || !places.are_shared()) return false;
  const std::vector<uint8_t> is_shared = shared_places(places);
  std::vector<Three> looked_for;
  for (const int32_t h : half_edges) {
    const Three three = sorted_ids(places.of_corner, h / 3);
    if (std::ranges::all_of(three, [&](int32_t place) { return is_shared[place] != 0; })) looked_for.push_back(three);
  }
  if (looked_for.empty()) return false;
  std::ranges::sort(looked_for);
  looked_for.erase(std::unique(looked_for.begin(), looked_for.end()), looked_for.end());
  std::vector<uint8_t> is_lowest(is_shared.size(), 0);
  for (const Three &three : looked_for) is_lowest[three[0]] = 1;
  size_t found = 0;
  for (int32_t triangle = 0; triangle < triangles.triangle_count; ++triangle) {
    checkpoint_at(triangle);
    const Three three = sorted_ids(places.of_corner, triangle);
    found += !left_out[triangle] && is_lowest[three[0]] && std::ranges::binary_search(looked_for, three);
  }
  return found > looked_for.size();
}

Copies find_copies(const Triangles &triangles, const Places &places, const std::vector<uint8_t> &left_out) {
  Copies copies;
  copies.group.assign(triangles.triangle_count, -1);
  copies.rank.assign(triangles.triangle_count, 0);
  copies.turned.assign(triangles.triangle_count, 0);
  std::vector<Member> members;
  members.reserve(triangles.triangle_count);
  for (int32_t triangle = 0; triangle < triangles.triangle_count; ++triangle) {
    checkpoint_at(triangle);
    if (!left_out[triangle]) members.push_back({sorted_ids(places.ids(triangles), triangle), triangle});
  }
  std::ranges::sort(members);
  for (size_t i = 0, end = 0; i < members.size(); i = end) {
    checkpoint_at(i);
    while (end < members.size() && members[end].places == members[i].places) ++end;
    copies.group[members[i].triangle] = members[i].triangle;
    if (end == i + 1) continue;
    std::vector<int32_t> group;
    for (size_t k = i; k < end; ++k) group.push_back(members[k].triangle);
    add_group(places.ids(triangles), std::move(group), copies);
  }
  return copies;
}

std::vector<int32_t> leave_out_copies(const Triangles &triangles, const Copies &copies, const std::vector<int32_t> &twin,
                                      std::vector<uint8_t> &left_out) {
  const Pieces pieces = trace_pieces(twin, left_out);
  std::vector<int32_t> size(pieces.count, 0), copied(pieces.count, 0), stands_in(left_out.size(), -1);
  for (const int32_t piece : pieces.triangle_piece)
    if (piece >= 0) ++size[piece];
  const auto place_of = [&](int32_t triangle) {
    const int32_t piece = pieces.triangle_piece[triangle];
    return std::pair(-size[piece], piece);
  };
  // Among triangles with the same key, the one of the best sheet stands in for the others.
  const auto look = [&](std::vector<int32_t> group, const auto &key) {
    std::ranges::sort(group, {}, [&](int32_t triangle) { return std::tuple(key(triangle), place_of(triangle), triangle); });
    int32_t best = group[0];
    for (const int32_t triangle : group) {
      if (key(triangle) != key(best)) best = triangle;
      if (place_of(best) < place_of(triangle) && stands_in[triangle] < 0) {
        stands_in[triangle] = best;
        ++copied[pieces.triangle_piece[triangle]];
      }
    }
  };
  for (size_t i = 0; i < copies.groups.size(); ++i) {
    checkpoint_at(i);
    look(copies.groups[i], [&](int32_t triangle) { return copies.turned[triangle]; });
    look(copies.groups[i], [&](int32_t triangle) { return sorted_ids(triangles.corner_vertex, triangle); });
  }
  bool any = false;
  for (size_t triangle = 0; triangle < left_out.size(); ++triangle) {
    const int32_t piece = pieces.triangle_piece[triangle];
    const bool is_copy = piece >= 0 && copied[piece] == size[piece];
    any = any || is_copy;
    if (is_copy) left_out[triangle] = 1;
    if (!is_copy) stands_in[triangle] = -1;
  }
  if (!any) return {};
  for (int32_t &other : stands_in) // it may have been left out itself, in favor of a better sheet
    while (other >= 0 && left_out[other]) other = stands_in[other];
  return stands_in;
}

} // namespace paradesc
