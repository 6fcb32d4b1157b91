// Triangles → rows of what does not depend on the center, which lanes load.
#pragma once

#include <atomic>
#include <cstdint>
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

// A triangle's plane and normals in full precision.
struct FacePlane {
  dvec3 normal;   // unit
  PlaneAxes axes; // the first along edge 0; zero if the triangle has no area
  double twice_area;
  bool is_needle;       // has the normal of the face behind it
  PlaneTensor gradient; // of the normals in the plane
  FacePlane(const CreasedSurface &surface, int32_t triangle);
};

// The rows of a surface, each made when some thread first asks for it.
class FaceRows {
public:
  FaceRows(const CreasedSurface &surface, double radius);
  const FaceRow &of(int32_t triangle) const;

private:
  FaceRow make(int32_t triangle) const;

  enum State : uint8_t { absent, begun, present };
  CreasedSurface surface_;
  double radius_;
  std::unique_ptr<FaceRow[]> rows_; // (triangles)
  std::unique_ptr<std::atomic<uint8_t>[]> states_;
};

} // namespace paradesc
