// Wedges → the centers that a texture-space engine evaluates at vertices.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/distortion.h"
#include "bake/surface_maps.h"
#include "mesh/atlas.h"
#include "mesh/normals.h"

#include "shared.h"

namespace paradesc {

// The sampling ellipse is larger than the ball, because curvature would leave the rim of an ellipse that just touches it empty.
inline constexpr float ellipse_enlargement = 1.25f;

// The surface at one moment, in the units of the buffers.
struct CenterSpace {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Normals &normals;
  const BakeSpace &bake_space;
  const DisplacedPoints *displaced; // null unless maps displace the surface
};

struct Centers {
  std::vector<int32_t> wedges;
  std::vector<int32_t> points;
  std::vector<uint8_t> primary; // 1: of its point's centers the one whose value the point takes
};

// Options that decide where centers lie.
struct CenterOptions {
  bool every_wedge;   // a center for each wedge of a point, else for its primary one
  uint32_t seed;      // of the pattern's rotations
  int buffer_size;    // texels along a side
  float ellipse_size; // the radius in buffer units, times the enlargement
};

Centers list_centers(const Charts &charts, const CenterOptions &options);
// Describes centers without position and normal. ellipses: (wedges) for radius 1.
std::vector<CenterData> describe_centers(const Charts &charts, const CenterOptions &options, const Centers &centers,
                                         const std::vector<vec4> &ellipses);
// Fills in position and normal.
void place_centers(const CenterSpace &space, const Centers &centers, std::vector<CenterData> &data);

// The median radius in texels over the centers' wedges, in the direction that has the fewest; radius is in buffer units.
// ellipses: of every step-th wedge, for radius 1.
double median_radius_in_texels(const Charts &charts, const CenterOptions &options, float radius,
                               const std::vector<vec4> &ellipses, size_t step);

} // namespace paradesc
