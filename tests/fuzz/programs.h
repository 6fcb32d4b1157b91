// A device's program takes longer to compile than all the rest of an input, and a context keeps 32 of them: so most computations
// take one of these, whatever their other options.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>

#include "paradesc/paradesc.h"

namespace paradesc::fuzz {

struct Program {
  const char *descriptor;
  int32_t relocation = PDESC_RELOCATION_CONNECTED, ellipse = PDESC_ELLIPSE_CENTER, estimator = PDESC_ESTIMATOR_SHAPE_OPERATOR,
          geodesic = PDESC_GEODESIC_LOCAL, distance = PDESC_DISTANCE_EUCLIDEAN, precision = PDESC_PRECISION_FULL;
  double adaptive = 0.0;
};

inline constexpr Program usual_programs[] = {
    {.descriptor = "mean_curvature"},
    {.descriptor = "shape_index", .distance = PDESC_DISTANCE_GEODESIC, .precision = PDESC_PRECISION_HALF},
    {.descriptor = "gaussian_curvature", .estimator = PDESC_ESTIMATOR_INTEGRAL, .adaptive = 0.05},
    {.descriptor = "mean_curvature", .estimator = PDESC_ESTIMATOR_EXTRAPOLATED},
    {.descriptor = "harris"},
    {.descriptor = "principal_direction_max", .relocation = PDESC_RELOCATION_AFFINE, .ellipse = PDESC_ELLIPSE_DIRECTIONAL},
    {.descriptor = "geodesic_area", .relocation = PDESC_RELOCATION_AFFINE, .geodesic = PDESC_GEODESIC_CHORDS},
    {.descriptor = "sphere_volume", .relocation = PDESC_RELOCATION_PAPER},
};

// Puts the options of one of them in, which the seed of the samples says, and gives its descriptor; one computation in eight
// stays as it is, and gives nullptr.
inline const char *choose_usual_program(pdesc_options &options) {
  const auto choice = static_cast<uint32_t>(options.seed);
  if (choice % 8 == 7) return nullptr;
  const Program &program = usual_programs[choice / 8 % std::size(usual_programs)];
  options.relocation = program.relocation;
  options.ellipse = program.ellipse;
  options.estimator = program.estimator;
  options.geodesic = program.geodesic;
  options.distance = program.distance;
  options.precision = program.precision;
  options.adaptive = program.adaptive;
  options.map_descriptor = nullptr;
  return program.descriptor;
}

} // namespace paradesc::fuzz
