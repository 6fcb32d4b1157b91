// Triangles around a center → what they add to the tensor of SolidMeasure, sixteen at a time, with the widest instructions that
// the processor has.
//
// Each lane is a triangle, in units of the radius and in floats: 2e-7 of an angle is the error of each term. Sums run in sixteen
// lanes whatever the width, so they have the same bits for all instructions.
#pragma once

#include <cstdint>
#include <vector>

namespace paradesc {

// The properties of a triangle that do not depend on the center. Rows of triangles without area, and of large ones, add nothing.
// Each run of four floats is loaded as one. Lengths are in radii, except for the corners, which must stay exact.
struct alignas(64) FaceRow {
  struct {
    float place[3], other; // other: twice the area, 0 for a needle, which is not seen; xx and xy of the excess
  } corner[3];
  float normal[3], excess_yy;        // the gradient's integral over the area, less the bends of edges that are not creases
  float axis[3], gradient_xx;        // the first of the plane's axes, and the gradient if it turns normals
  float smooth_bend[3], gradient_xy; // bends of edges that are not creases
  float bend[3], gradient_yy;        // at each half-edge, positive if convex; 0 at boundaries
  int32_t twin[3];                   // of the half-edges: ~twin if that lies in a facet, NO_TWIN at boundaries
  int32_t state;
};

// A center for lanes. Its place is the sum of two floats, so that differences from corners are rounded only once.
struct LaneCenter {
  float place[3], rest[3], normal[3], t1[3], t2[3];
  float per_radius;
  float rounding; // of coordinates, in radii
};

struct FaceSums {
  float hard[3], smooth[3]; // xx, xy, yy: as SolidMeasure::Sums, in units of the radius
};

inline constexpr int FACE_LANES = 16;

// The function of one instruction set.
struct FaceTarget {
  const char *name;
  // rows: padded to a multiple of FACE_LANES by any rows. own: the first ones lie around the center.
  FaceSums (*add)(const FaceRow *const *rows, int32_t count, int32_t own, const LaneCenter &center);
};
// The instruction sets that this processor has, the widest first.
std::vector<FaceTarget> face_targets();

} // namespace paradesc
