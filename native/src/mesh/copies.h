// Triangles → groups of copies: triangles at the same three places, wound alike or the other way.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/triangles.h"
#include "mesh/weld.h"

namespace paradesc {

struct Copies {
  std::vector<int32_t> group;               // (triangle_count) the first triangle at the same three places; -1: left out
  std::vector<int32_t> rank;                // (triangle_count) earlier triangles of its group with the same winding
  std::vector<uint8_t> turned;              // (triangle_count) 1: wound the other way than the first of its group
  std::vector<std::vector<int32_t>> groups; // of several triangles each, ascending
};

// Returns whether some triangle of these half-edges, at places shared with other vertices, lies at the same three places as
// another one.
bool has_copies_of(const Triangles &triangles, const Places &places, const std::vector<uint8_t> &left_out,
                   std::span<const int32_t> half_edges);

Copies find_copies(const Triangles &triangles, const Places &places, const std::vector<uint8_t> &left_out);

// Leaves out sheets that add nothing. A sheet is a set of triangles paired with each other; it adds nothing if each of its
// triangles has a copy in a larger sheet (among equally large ones: in the first) that is wound the same way or has the same
// vertices. Sheets that coincide with others in only some triangles stay, and so do back faces with vertices of their own. twin:
// as Pairing's. Returns for each triangle left out here the one that stands in for it, else -1; an empty array if none was.
std::vector<int32_t> leave_out_copies(const Triangles &triangles, const Copies &copies, const std::vector<int32_t> &twin,
                                      std::vector<uint8_t> &left_out);

} // namespace paradesc
