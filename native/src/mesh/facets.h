// Triangles → facets: connected triangles of one plane over which the normals are linear, as what is left of them for integrals
// over the plane: straight sides. A flat side of a solid has as many however fine its triangles are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/creases.h"
#include "mesh/halfedge.h"
#include "mesh/normal_gradient.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// Half-edges in a straight line, behind which one facet lies, one triangle that is in none, or nothing.
struct FacetSide {
  dvec3 begin, end;
  double bend;       // by which the surface turns there, positive where it is convex; 0 at boundaries
  int32_t neighbor;  // a facet, or -1
  int32_t half_edge; // the first of them in Facets::outline
  int32_t half_edges;
  bool is_crease;
};

struct Facet {
  dvec3 normal; // unit
  dvec3 middle; // of its area
  PlaneAxes axes;
  double area;
  double reach;         // of its corners from the middle
  PlaneTensor spread;   // of the area around the middle: second moments
  PlaneTensor gradient; // of the normals
  PlaneTensor excess;   // its sum over the area, without that of the bends of sides that are no creases
  bool is_convex;       // so that each ball cuts one connected part out of it
  int32_t side_begin, side_end;
};

struct Facets {
  std::vector<int32_t> of_triangle; // (triangle_count) -1: by itself
  std::vector<int32_t> side_of;     // (3 * triangle_count) of a half-edge on an outline; else -1
  std::vector<Facet> facet;
  std::vector<FacetSide> side;  // facet after facet, loop after loop, counter-clockwise
  std::vector<int32_t> outline; // half-edges, side after side

  std::span<const int32_t> half_edges(const FacetSide &s) const {
    return std::span(outline).subspan(static_cast<size_t>(s.half_edge), static_cast<size_t>(s.half_edges));
  }
};

// Every triangle by itself.
Facets no_facets(const Triangles &triangles);
// Of two triangles or more; none reaches over a crease.
Facets find_facets(const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals, const Creases &creases);

} // namespace paradesc
