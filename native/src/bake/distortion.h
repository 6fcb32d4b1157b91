// Positions and UVs → the metric of the parameterization: E, F, G and area element of each triangle (paper eq. 1), and the
// sampling ellipse of each wedge (paper 3.4). All are in buffer units: the bounding box's center is the origin, and its longest
// half side is 1.
#pragma once

#include <vector>

#include "mesh/charts.h"
#include "mesh/halfedge.h"
#include "mesh/triangles.h"

namespace paradesc {

struct BakeSpace {
  dvec3 center{0.0};
  double scale = 1.0; // buffer units per unit of the positions
  vec3 to_buffer(vec3 position) const { return vec3((dvec3(position) - center) * scale); }
};

BakeSpace bake_space_of(const Box &box);

// E, F, G, |P_u x P_v| of a triangle on a chart.
vec4 form_of(const Triangles &triangles, const Charts &charts, const BakeSpace &bake_space, size_t triangle);

// (wedges) columns of the 2x2 map from the unit disk to (u, v) offsets for radius 1: the square root of the mean inverse metric
// over the triangles at the wedge, weighted by their angle there. step: only every step-th wedge gets an ellipse.
std::vector<vec4> sampling_ellipses(const Triangles &triangles, const Charts &charts, const BakeSpace &bake_space,
                                    size_t step = 1);

} // namespace paradesc
