// Triangles → facets: connected coplanar triangles with linear normals, stored as all that integrals over the plane need: a few
// straight sides. The flat side of a solid has the same sides however fine its triangles are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/creases.h"
#include "mesh/halfedge.h"
#include "mesh/normal_gradient.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"
#include "support/unset.h"

namespace paradesc {

// A straight run of half-edges that all border the same thing: one facet, one triangle outside of all facets, or nothing.
struct FacetSide {
  dvec3 begin, end;
  double bend;       // angle by which the surface turns here, positive where it is convex; 0 at boundaries
  int32_t neighbor;  // a facet, or -1
  int32_t half_edge; // the first of them in Facets::outline
  int32_t half_edges;
  bool is_crease;
};

struct Facet {
  dvec3 normal; // unit
  dvec3 middle; // of its area
  PlaneAxes axes;
  PlaneTensor gradient; // of the normals
  bool is_convex;       // a ball then cuts only one part out of the facet
  int32_t side_begin, side_end;
};

struct Facets {
  std::vector<int32_t> of_triangle; // (triangle_count) -1: by itself
  std::vector<int32_t> side_of;     // (3 * triangle_count) of a half-edge on an outline; else -1
  UnsetVector<Facet> facet;
  UnsetVector<FacetSide> side;  // facet after facet, loop after loop, counter-clockwise
  UnsetVector<int32_t> outline; // half-edges, side after side

  // Returns the angle by which the surface turns at a half-edge of a facet.
  double bend_at(int32_t half_edge) const { return side_of[half_edge] >= 0 ? side[side_of[half_edge]].bend : 0; }
  std::span<const int32_t> half_edges(const FacetSide &s) const {
    return std::span(outline).subspan(static_cast<size_t>(s.half_edge), static_cast<size_t>(s.half_edges));
  }
};

// The result without facets: every triangle stays by itself.
Facets no_facets(const Triangles &triangles);
// Finds facets of at least two triangles each; none extends across a crease.
Facets find_facets(const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals, const Creases &creases,
                   int threads = 0);

} // namespace paradesc
