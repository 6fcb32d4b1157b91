// Points → the triangles that are connected to each within the ball, exactly.
//
// Cells resolve what is connected only to the size of a cell. Where a neighborhood holds more surface than a disk does, a
// neighboring finger may have come in with a cell that holds both: there, samples are taken on these triangles only.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mesh/halfedge.h"
#include "mesh/triangles.h"
#include "support/pool.h"

namespace paradesc {

struct ConnectedTriangles {
  std::vector<int32_t> begin;    // (points + 1) into triangle
  std::vector<int32_t> triangle; // sorted, of each point; none: more than the limit, or the area that was expected
  std::vector<double> area;      // (points) of those triangles within the ball, to a few per cent; 0: more than the limit
};

// Points whose area is that of `areas` within the tolerance need no list of triangles.
struct ExpectedAreas {
  std::span<const double> areas; // (points), or empty: all are listed
  double tolerance = 0.0;
};

class SharedFlood;

// What is kept from call to call belongs to one mesh and one radius, in units of the positions. limit: triangles of one point.
class ConnectedTriangleSearch {
public:
  ConnectedTriangleSearch(const Triangles &triangles, const HalfEdges &half_edges, double radius, size_t limit, int threads);
  ~ConnectedTriangleSearch();
  // Points that lie near each other are best in a row: floods are shared.
  ConnectedTriangles run(std::span<const int32_t> points, const ExpectedAreas &expected = {});

private:
  const Triangles &triangles_;
  const HalfEdges &half_edges_;
  double radius_;
  size_t limit_;
  int threads_;
  Pool<SharedFlood> floods_;
};

} // namespace paradesc
