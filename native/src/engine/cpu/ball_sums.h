// Balls around sixteen centers at a time → the exact sums of the shape operator over what of the surface lies in each, by the
// widest instructions that the processor has.
//
// A lane is a center, and a set of centers is sixteen bits: what a point, an edge or a triangle is to sixteen balls is algebra on
// such sets. Triangles in a ball as a whole, or with two corners in it, count by moments that are known beforehand; at the rim
// the triangle at the corner that is alone on its side is added or subtracted, and the arc beyond its chord. Sums of one center
// run over triangles in their order, so that they have the same bits whatever the instructions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace paradesc {

inline constexpr int group_lanes = 16; // centers

// Moments of a triangle from the origin of its patch, times its area: 1; position; normal; products of positions xx, yy, zz, xy,
// xz, yz; and of position and normal xx, yy, zz, xy + yx, xz + zx, yz + zy. Normals are linear through those at the middles of
// the edges. Then its area again, and the variance of positions along normals.
enum Moment { moment_area, moment_x, moment_n = 4, moment_xx = 7, moment_xn = 13, moment_facet = 19, moment_noise, moments };
inline constexpr int moment_row = 24; // floats of a row, as whole vectors have them
struct alignas(32) MomentRow {
  float of[moment_row];
};

// The rim needs of a triangle: corners and normals at them, the first two once more, so that those from any corner on follow
// each other. One is read by four floats at a time.
struct alignas(64) RimTriangle {
  float corner[5][3], area;
  float normal[5][3], per_twice_area;
};

// Spheres side by side, in lists that end with sixteen or more that are nowhere: each holds a patch, sixteen patches, or 256.
struct SphereList {
  const float *middle[3], *reach;
  int32_t count; // but for those
};

// A surface in the order of its patches, at one moment; see PatchSurface. A node is sixteen patches. Its moments have the node's
// middle for origin where that is near; else each patch has its own.
struct PatchArrays {
  const int32_t *patch_begin, *triangle_begin, *corner;
  const float *position[3]; // of points
  const float *noise;       // of triangles
  RimTriangle *rim;         // of triangles, and behind them one that is zero
  MomentRow *moment;        // likewise; then those of whole patches
  float *sphere[4];         // of patches: middle and reach of all triangles
  float *own_reach;         // (patches) of the points
  float *origin[3];         // (patches)
  uint8_t *apart;           // (nodes) 1: its patches have origins of their own
  SphereList levels[3];     // spheres of patches, of nodes, and above
  int32_t patches, triangles;

  int32_t row_of_patch(int32_t patch) const { return triangles + 1 + patch; }
};

struct alignas(64) CenterLanes {
  float position[3][group_lanes]; // behind the last center, nowhere
  float normal[3][group_lanes];
  float middle[3], spread; // a sphere that holds all of them
  int32_t count;
  float radius;
  uint32_t all() const { return (uint32_t{1} << count) - 1; }
};

// The surface near a group: which of its patches are near, and the centers in whose balls a patch as a whole is: of all of
// them or of some.
enum class Nearness : uint8_t { outside, some, inside };
struct NearPatches {
  int32_t *patch;
  Nearness *nearness;
  int32_t patches;
  uint16_t *in, *reached; // (points) sets of centers in whose balls a point lies, and that it is connected to
  int32_t *point;         // that lie in any ball
  int32_t points;
};

// Items that belong to sets of centers → lists of the items of each center.
struct CenterLists {
  int32_t *item;
  int32_t *centers; // sets
  int32_t count;
  int32_t *of_center[group_lanes]; // each with room for all and for sixteen more, as the two above
};
// Triangles, and for each corner the set of centers in whose balls it lies, connected to them.
struct TouchedTriangles {
  int32_t *triangle, *corner[3];
  int32_t count;
};
// Rows of moments of what counts as a whole, and corners that are alone on their side of the rim, as places of their first float
// among those of RimTriangles.
struct GroupLists {
  TouchedTriangles touched;
  CenterLists wholes, corners;
};

// As Moments of the kernels: area; xx, xy, yy over r^2; xn, xm + yn, ym over r; facets; noise over r^2.
inline constexpr int ball_sums = 9;
using BallSums = float[ball_sums][group_lanes];

// One set of instructions.
struct BallTarget {
  const char *name;
  // One node: normals are those at its triangles' corners, (triangles, 3, 3) from its first one on.
  void (*refit)(const PatchArrays &surface, int32_t node, const float *normals);
  // Patches near the centers, in their order. Returns how many.
  int32_t (*find)(const PatchArrays &surface, const CenterLanes &centers, int32_t *patches);
  void (*look)(const PatchArrays &surface, const CenterLanes &centers, NearPatches &near);
  // The set of centers whose balls the edge between two points outside meets.
  uint32_t (*dips)(const PatchArrays &surface, const CenterLanes &centers, int32_t from, int32_t to);
  void (*add)(const PatchArrays &surface, const CenterLanes &centers, const NearPatches &near, bool with_noise, GroupLists &lists,
              BallSums &sums);
};
// Those that this processor has, the widest first.
std::vector<BallTarget> ball_targets();

} // namespace paradesc
