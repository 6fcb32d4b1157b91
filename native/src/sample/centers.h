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

// The sampling ellipse reaches beyond the ball: curvature leaves the rim of one that just touches it empty.
inline constexpr float ellipse_enlargement = 1.25f;

// The surface at one moment, in the units of the buffers.
struct CenterSpace {
  const Triangles &triangles;
  const HalfEdges &half_edges;
  const Normals &normals;
  const BakeSpace &bake_space;
  const DisplacedPoints *displaced; // where maps displace the surface, else null
};

struct Centers {
  std::vector<int32_t> wedges; // -1: the point has no wedge
  std::vector<int32_t> points;
  std::vector<int32_t> order; // the number that each center had when the list was made
  // In the order in which the list was made: the point, and whether the center is its point's primary one.
  std::vector<int32_t> listed_point;
  std::vector<uint8_t> listed_primary;

  // Center i becomes the one that was center order_now[i].
  void permute(const std::vector<int32_t> &order_now);
};

// Options that decide where centers lie.
struct CenterOptions {
  bool every_wedge;   // a center for each wedge of a point, else for its primary one
  bool connected;     // points without a wedge get a center too, and no center has an ellipse
  uint32_t seed;      // of the pattern's rotations
  int buffer_size;    // texels along a side
  float ellipse_size; // the radius in buffer units, times the enlargement
};

Centers list_centers(const Charts &charts, const CenterOptions &options);
// Without position and normal. ellipses: (wedges) for radius 1; not read in the connected relocation.
std::vector<CenterData> describe_centers(const Charts &charts, const CenterOptions &options, const Centers &centers,
                                         const std::vector<vec4> &ellipses);
// Gives them position and normal.
void place_centers(const CenterSpace &space, const Centers &centers, std::vector<CenterData> &data);

// The median over the centers' wedges of the radius (in buffer units) in texels, in the direction that has the fewest. ellipses:
// of every step-th wedge, for radius 1.
double median_radius_in_texels(const Charts &charts, const CenterOptions &options, float radius,
                               const std::vector<vec4> &ellipses, size_t step);

} // namespace paradesc
