// Triangles → rows of what does not depend on the center, which lanes load.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>

#include "engine/creases/face_sums.h"
#include "mesh/creases.h"
#include "mesh/facets.h"
#include "mesh/halfedge.h"
#include "mesh/normal_gradient.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// A surface with creases. Its parts are borrowed.
struct CreasedSurface {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Normals &normals;
  const Creases &creases;
  const Facets &facets; // of these normals and creases, or none
};

// Bends below this angle, in radians, are ignored.
inline constexpr double LEAST_BEND = 1e-8;
// A triangle with an edge longer than this many radii is summed in double precision: floats round its far corners too much.
inline constexpr double LARGE_FACE = 8;

// Returns whether normals turn by more than their rounding within the radius; ignoring less changes H by at most this over the
// radius.
bool turns(const PlaneTensor &gradient, double radius);

// Returns whether the bend at an edge is more than rounding, and the edge no crease.
bool is_smooth_bend(const CreasedSurface &surface, int32_t half_edge, float bend);

// A triangle's plane and normals in full precision.
struct FacePlane {
  dvec3 normal;   // unit
  PlaneAxes axes; // the first along edge 0; zero if the triangle has no area
  double twice_area;
  bool is_needle;       // has the normal of the face behind it
  PlaneTensor gradient; // of the normals in the plane
  FacePlane(const CreasedSurface &surface, int32_t triangle);
};

inline constexpr int32_t NO_TWIN = std::numeric_limits<int32_t>::min();
enum FaceState : int32_t { FACE_ABSENT, FACE_BEGUN, FACE_PRESENT, FACE_LARGE };

// The rows of a surface, each made when some thread first asks for it. Memory for all is reserved, but the system provides only
// the part that is used.
class FaceRows {
public:
  FaceRows(const CreasedSurface &surface, double radius);
  const FaceRow &of(int32_t triangle) const {
    FaceRow &row = rows_[triangle];
    if (__atomic_load_n(&row.state, __ATOMIC_ACQUIRE) < FACE_PRESENT) [[unlikely]]
      provide(triangle, row);
    return row;
  }
  // Returns the angle by which the surface turns at a half-edge, positive if convex; 0 at boundaries. Needs no row in a facet.
  double bend_at(int32_t half_edge) const;
  void prefetch(int32_t triangle) const { __builtin_prefetch(rows_ + triangle); }

private:
  void provide(int32_t triangle, FaceRow &row) const;
  FaceState fill(int32_t triangle, FaceRow &row) const;

  struct Free {
    void operator()(void *memory) const { std::free(memory); }
  };
  CreasedSurface surface_;
  double radius_;
  std::unique_ptr<void, Free> memory_;
  FaceRow *rows_; // (triangles)
};

} // namespace paradesc
