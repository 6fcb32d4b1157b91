// Triangles → pieces of them, as many as the lengths of edges ask for; no piece has a corner on the side of another.
//
// An edge is halved until its parts are short enough, by a length that both of its triangles agree on. A triangle is cut from the
// middle of its longest edge that is not halved enough to the corner across, and the cut is an edge like any other.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "mesh/halfedge.h"

namespace paradesc {

// The sides of a triangle by two measures, in units of the length that is short enough. The shorter of the two lengths counts.
struct TriangleMeasure {
  vec2 image1{0.0f}, image2{0.0f}; // from corner 0 to corners 1 and 2
  vec3 space1{0.0f}, space2{0.0f};
};
using MeasureTriangle = std::function<TriangleMeasure(int32_t triangle)>;

// The halvings of edges, the cuts of triangles, and the resulting counts. All of it follows from the mesh and the measure; a
// different measure may well give the same plan.
struct DivisionPlan {
  float coarsening = 1.0f;          // lengths are divided by it: above 1 where there would be too many pieces
  std::vector<uint8_t> halvings;    // (3 * triangles) of each half-edge, equal on both sides
  std::vector<uint8_t> cut;         // (pieces) the cuts of each triangle in order, one fewer than it has pieces
  std::vector<int32_t> piece_begin; // (triangles + 1) pieces of each triangle; none of those left out
  std::vector<int32_t> inner_begin; // (triangles + 1) points within each triangle
  std::vector<int32_t> side_begin;  // (3 * triangles + 1) points on each half-edge, between its ends
  std::vector<int32_t> edge_begin;  // (3 * triangles + 1) the same, of one half-edge of each pair

  bool operator==(const DivisionPlan &) const = default;
  int32_t pieces() const { return piece_begin.empty() ? 0 : piece_begin.back(); }
  int32_t new_points() const { return edge_begin.empty() ? 0 : edge_begin.back() + inner_begin.back(); }
  int32_t side_points() const { return side_begin.empty() ? 0 : side_begin.back(); }
};

// Plans at most most_pieces pieces, or as many as the mesh has triangles if that is more.
DivisionPlan plan_division(const HalfEdges &half_edges, const MeasureTriangle &measure, int32_t most_pieces, int threads);

// A place on a triangle, by weights of its corners 1 and 2.
struct TrianglePlace {
  int32_t triangle;
  vec2 weights;
};

// Points are numbered in this order: points of the mesh by their own numbers, points on edges, points within triangles.
// A fan stands for the corners of pieces that share a place on a triangle. Fans are numbered: at corners of triangles; on their
// sides, along the direction of each half-edge; within triangles.
struct Division {
  DivisionPlan plan;
  HalfEdges half_edges;                                   // of the pieces; each point is a vertex
  std::shared_ptr<const std::vector<int32_t>> corner_fan; // (3 * pieces)
  std::vector<vec2> fan_weights;                          // (fans) the place on the triangle, as in TrianglePlace
  std::vector<int32_t> tree; // (2 * pieces) the tree of cuts of each triangle: its cut, then the tree of one half; see at()

  size_t first_side_fan() const { return plan.halvings.size(); }
  size_t first_inner_fan() const { return first_side_fan() + static_cast<size_t>(plan.side_points()); }
  // Maps a place on a divided triangle to the place on the piece that contains it.
  TrianglePlace at(TrianglePlace place) const;
};

Division divide(const HalfEdges &half_edges, const DivisionPlan &plan, int threads);

} // namespace paradesc
