// Points → the triangles that the surface reaches from each within the ball, exactly.
//
// Cells tell what is connected to the size of a cell. Where a neighborhood holds more surface than a disk does, a neighboring
// finger may have come in with a cell that holds both: there the samples are taken on these triangles only.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

struct Reach {
  std::vector<int32_t> begin;    // (points + 1) into triangle
  std::vector<int32_t> triangle; // sorted, of each point; none: more than `limit`, or the area that was expected
  std::vector<double> area;      // (points) of those triangles within the ball, to a few per cent
};

// Points whose area is that of `areas` within the tolerance need no list of triangles.
struct ExpectedAreas {
  std::span<const double> areas; // (points), or empty: all are listed
  double tolerance = 0.0;
};

// radius in units of the positions.
Reach reach_exactly(const Triangles &triangles, const HalfEdges &half_edges, std::span<const int32_t> points, double radius,
                    size_t limit, int threads, const ExpectedAreas &expected = {});

// Whether the segment from a to b comes nearer to the center than the radius.
bool segment_in_ball(dvec3 a, dvec3 b, dvec3 center, double radius);

} // namespace paradesc
