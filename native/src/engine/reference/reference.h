// The oracle: descriptors by exact quadrature over the connected part of the surface within r, in object space, in double.
// It shares positions and normals with the other engines and nothing else.
#pragma once

#include <functional>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "engine/reference/window.h"
#include "mesh/halfedge.h"
#include "mesh/normals.h"
#include "mesh/triangles.h"

namespace paradesc {

// The integrals at one point. w is area; d = q - p, rho = |d|, n the unit normal at p, n_i that at q.
struct ReferenceNeighborhood {
  double radius = 0;
  double area = 0;                                                  // integral of w
  double rho = 0;                                                   // of w rho
  double height = 0;                                                // of w n.d
  double bending = 0;                                               // of w |n - n_i|^2 / rho^2
  double geodesic_area = 0;                                         // area within r along the surface
  double mean = 0, gauss = 0, k1 = 0, k2 = 0;                       // H, K, k1 >= k2 by the requested estimator; NaN if undefined
  double standard_error = std::numeric_limits<double>::quiet_NaN(); // of H by noise of the positions; NaN: not known
  dvec3 direction_max{0}, direction_min{0};                         // of the shape operator, unit
  bool boundary = false;                                            // a mesh boundary lies within the ball
  ReferenceWindow window;                                           // if a map is given
};

template <int components> using ReferenceValue = std::conditional_t<components == 1, double, dvec3>;

// One of these exists for each row of descriptors.def and of descriptor/operators.def; it returns NaN if the value is undefined.
#define DESCRIPTOR(name, label, description, power, is_signed, neutral, low, high, components, terms)                            \
  ReferenceValue<components> reference_##name(const ReferenceNeighborhood &neighborhood);
#include "descriptor/descriptors.def"
#undef DESCRIPTOR
#define OPERATOR(name, label, description, power, degree, needs, is_signed, neutral, low, high, components, terms)               \
  ReferenceValue<components> reference_##name(const ReferenceNeighborhood &neighborhood);
#include "descriptor/operators.def"
#undef OPERATOR

struct ReferenceField {
  std::vector<std::vector<float>> values; // [descriptor asked for][point, component]
  std::vector<uint8_t> boundary;          // (point_count)
};

struct ReferenceSettings {
  double radius;
  int32_t estimator = 0;                  // pdesc_estimator of the curvatures
  bool geodesic_ball = false;             // the neighborhood ends where the distance along the surface exceeds the radius
  const std::vector<vec4> *map = nullptr; // (point_count) gradient and value of the map; only operators need it
  double map_radius = 0;                  // radius at which the map was computed
  double map_sigma = 0;                   // sigma of the operators' Gaussian windows; 0: operators fit quadratics
  double harris_k = 0;
  std::span<const int32_t> points = {}; // to compute at; empty: at all. Values at other points are NaN
};

// descriptors: indices into the registry. progress(fraction) may throw to cancel.
ReferenceField compute_reference(const Triangles &triangles, const HalfEdges &half_edges, const Normals &normals,
                                 const ReferenceSettings &settings, std::span<const int> descriptors, int threads,
                                 const std::function<void(double)> &progress);

} // namespace paradesc
