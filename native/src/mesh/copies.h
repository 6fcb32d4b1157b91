// Triangles → those that are copies of others: they lie at the same three places, wound alike or the other way.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/triangles.h"
#include "mesh/weld.h"

namespace paradesc {

struct Copies {
  std::vector<int32_t> group;               // (triangle_count) the first triangle at the same three places; -1: left out
  std::vector<int32_t> rank;                // (triangle_count) how many before it in its group are wound the same way
  std::vector<uint8_t> turned;              // (triangle_count) 1: wound the other way than the first of its group
  std::vector<std::vector<int32_t>> groups; // of several triangles each, ascending
};

// Whether a triangle of these half-edges, whose places are other vertices' too, lies at the same three places as another one.
bool has_copies_of(const Triangles &triangles, const Places &places, const std::vector<uint8_t> &left_out,
                   std::span<const int32_t> half_edges);

Copies find_copies(const Triangles &triangles, const Places &places, const std::vector<uint8_t> &left_out);

// Leaves out the sheets, triangles that are paired with each other, of which every triangle has a copy in a larger sheet (of
// equally large ones the first) that is wound the same way or has the same vertices: all that they could add is there. Sheets
// that touch others in some triangles alone stay, and so do back faces with vertices of their own. twin: as Pairing's. Returns
// the triangle that stands for each that was left out here, and -1 for the others; where none was, nothing.
std::vector<int32_t> leave_out_copies(const Triangles &triangles, const Copies &copies, const std::vector<int32_t> &twin,
                                      std::vector<uint8_t> &left_out);

} // namespace paradesc
