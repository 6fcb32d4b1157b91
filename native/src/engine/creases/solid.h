// Creases around a center → the curvature tensor of the creases and the surface between them within the ball, and the weight of
// that tensor.
//
// H of the solid (paper eq. 8, with the true volume V of ball and solid) is a sum over the surface that needs no normal at p:
//   2 H = 8/(3 pi r) (sum of b_e over the edges e at p + integral of h (1/rho^3 - 1/r^3)), h = d.f, f the face's normal,
// b_e the angle by which the surface turns at e; both follow from the divergence of d (1 - r^3/rho^3), which vanishes on the
// ball's rim, and from the solid angle at p, 2 pi - sum of b_e. Each term turns the surface about one axis; its direction in the
// tensor is perpendicular to that axis. Bends at edges that are not creases represent a smooth surface: they are subtracted, and
// the gradients of normals are added instead, both by H's kernel g for small bends: 2 H = 8/(pi r^4) integral of g (k1 + k2).
#pragma once

#include <cstdint>
#include <vector>

#include "engine/creases/closed_forms.h"
#include "engine/creases/face_rows.h"
#include "engine/creases/facet_flood.h"
#include "engine/creases/near.h"

namespace paradesc {

// The data that the threads of one pass share.
struct SolidSurface {
  CreasedSurface parts;
  double radius;
  NearCreases near;
  FaceRows rows;
  FaceTarget target = face_targets()[0];
  SolidSurface(const CreasedSurface &surface, double radius_)
      : parts(surface), radius(radius_), near(surface, radius_), rows(surface, radius_) {}
};

struct SolidCenter {
  dvec3 position;
  dvec3 normal, t1, t2; // orthonormal
  int32_t triangle;
  int32_t point; // -1: the center lies within the triangle
};

struct SolidTensor {
  double weight = 0;             // 0 if no crease comes nearer than CREASE_REACH r, 1 if one meets the ball
  double xx = 0, xy = 0, yy = 0; // in the center's tangents, one over units of the positions
};

// Reused by one thread from center to center, so that arrays stay allocated.
class SolidMeasure {
public:
  explicit SolidMeasure(const SolidSurface &shared);
  bool is_near_crease(dvec3 position, int32_t triangle); // at() of any other center has the weight 0
  SolidTensor at(const SolidCenter &center);             // requires a call of is_near_crease() for its place

private:
  // A symmetric tensor in the tangent plane of the center.
  struct Tensor {
    double xx = 0, xy = 0, yy = 0;
    void add(double amount, dvec2 v);
  };
  struct Sums {
    Tensor hard, smooth; // of the solid; of a surface that bends little
  };

  void flood(double radius);
  double weight();
  double nearest_reached() const;
  void add_own_edges(Tensor &tensor) const;
  void add_triangles(Sums &sums);
  void add_large_triangle(Sums &sums, int32_t triangle);
  LaneCenter lane_center() const;
  // The functions for facets are in solid_facets.cpp.
  double height_over(const Facet &facet, const FacetPart &part) const;
  void cut(const FacetPart &part, double height);
  double arcs_of(const FacetPart &part, double turn) const;
  void add_part(Sums &sums, const FacetPart &part);
  // These add a plane seen under a solid angle, a bend along an edge, or a gradient of normals in a plane.
  void add_plane(Tensor &tensor, dvec3 normal, double height, double amount) const;
  void add_bend(Tensor &tensor, dvec3 normal, dvec3 along, double amount) const;
  void add_turn(Tensor &tensor, dvec3 normal, const PlaneAxes &axes, const PlaneTensor &there, double amount) const;

  const SolidSurface &shared_;
  const CreasedSurface &surface_;
  double radius_;
  SolidCenter center_{};
  double rounding_ = 0; // of the center's coordinates
  FacetFlood flood_;
  std::vector<NearCrease> near_; // those of the center
  CutRegion region_;             // of the last cut
};

} // namespace paradesc
