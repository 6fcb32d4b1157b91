// Points and texels of the surface → the centers from which samples march.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/surface_maps.h"
#include "engine/engine.h"
#include "mesh/charts.h"

#include "shared.h"

namespace paradesc {

// The sampling ellipse is larger than the ball, because curvature would leave the rim of an ellipse that just touches it empty.
inline constexpr float ellipse_enlargement = 1.25f;

struct CenterOptions {
  uint32_t seed;      // of the pattern's rotations
  int buffer_size;    // texels along a side
  float ellipse_size; // the radius in buffer units, times the enlargement
};

// Numbers the centers that lie on a chart.
std::vector<int32_t> centers_on_charts(const Charts &charts, const Centers &centers);

// Describes the centers of these numbers. ellipses: (wedges) for radius 1. displaced: null unless maps displace the surface.
std::vector<CenterData> describe_centers(const Charts &charts, const CenterOptions &options, const Centers &centers,
                                         const std::vector<int32_t> &numbers, const std::vector<vec4> &ellipses,
                                         const DisplacedPoints *displaced);

// The median radius in texels over the primary wedges, in the direction that has the fewest; radius is in buffer units.
// ellipses: of every step-th wedge, for radius 1.
double median_radius_in_texels(const Charts &charts, int buffer_size, float radius, const std::vector<vec4> &ellipses,
                               size_t step);

} // namespace paradesc
