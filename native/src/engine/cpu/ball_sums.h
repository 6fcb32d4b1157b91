// Balls around sixteen centers at a time → the exact sums of the shape operator over the surface in each ball, computed with the
// widest instructions that the processor has.
//
// Each lane holds one center, and a set of centers is a mask of sixteen bits. Bitwise operations on such sets classify points,
// edges and triangles against sixteen balls at once. A triangle within a ball, or with two corners in it, counts as a whole by
// precomputed moments. At the rim, the triangle at the corner that is alone on its side is added or subtracted, and so is the
// segment between the chord and the arc. The sums of a center run over triangles in their order, so they have the same bits for
// all instructions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace paradesc {

inline constexpr int group_lanes = 16; // centers

// Moments of a triangle about the origin of its patch, times its area: 1; position; normal; the products of positions xx, yy, zz,
// xy, xz, yz; and the products of position and normal xx, yy, zz, xy + yx, xz + zx, yz + zy. Normals are the linear function with
// the unit normals at the edge midpoints. Then follow the squared area, and the area times the variance along normals.
enum Moment { moment_area, moment_x, moment_n = 4, moment_xx = 7, moment_xn = 13, moment_facet = 19, moment_noise, moments };
inline constexpr int moment_row = 24; // floats of a row, padded to whole vectors
struct alignas(32) MomentRow {
  float of[moment_row];
};

// The data of a triangle that the rim needs: corners and the normals there, which have length 1 if the triangle is turning; see
// PatchArrays. The first two corners are repeated, so that three consecutive ones start at any corner. Each is loaded as four
// floats.
struct alignas(64) RimTriangle {
  float corner[5][3], area;
  float normal[5][3], per_twice_area;
};

// Bounding spheres as structure of arrays, padded with at least sixteen far away ones. Each bounds 1, 16 or 256 patches.
struct SphereList {
  const float *middle[3], *reach;
  int32_t count; // without the padding
};

// A surface in the order of its patches, at one time; see PatchSurface. Sixteen patches are a batch. If the batch's middle is
// near its patches, it is the origin of their moments; else each patch has an origin of its own.
struct PatchArrays {
  const int32_t *patch_begin, *triangle_begin, *corner, *cluster_begin, *cluster_node; // as in PointPatches
  const float *position[3]; // of nodes: points, or the means of clusters
  const float *node_reach;  // bound on the distance of a cluster's surface from its mean; 0 for points
  const float *noise;       // of triangles
  RimTriangle *rim;         // (triangles + 1) the last one is zero
  int32_t *turning;         // (triangles) -1: normals turn too much on it to vary linearly; 0: they do not
  MomentRow *moment;        // (triangles + 1) the last one is zero; then sums over each patch, and over each cluster
  float *sphere[4];         // (patches) bounding spheres of all triangles: middle and reach
  float *own_reach;         // (patches) reach of the patch's own nodes
  float *origin[3];         // (patches)
  uint8_t *apart;           // (batches) 1: each of its patches has an origin of its own
  uint8_t *has_long_edge;   // (patches) 1: some triangle has an edge of at least the length `large`
  uint8_t *has_listed;      // (patches) 1: some triangle has neither moments nor a part at the rim, and must be summed by itself
  SphereList levels[3];     // spheres of patches, of batches, and of sixteen batches
  int32_t patches, triangles;
  float large; // triangles with such long edges are summed by themselves, and smaller ones where normals turn

  int32_t row_of_patch(int32_t patch) const { return triangles + 1 + patch; }
  int32_t row_of_cluster(int32_t cluster) const { return triangles + 1 + patches + cluster; }
};

struct alignas(64) CenterLanes {
  float position[3][group_lanes]; // far away behind the last center
  float normal[3][group_lanes];
  float middle[3], spread; // bounding sphere of the centers
  int32_t count;
  float radius;
  uint32_t all() const { return (uint32_t{1} << count) - 1; }
};

// A patch near a group.
struct NearPatch {
  int32_t patch;
  uint16_t within; // the set of centers whose balls contain all of it
  bool has_points; // whether any ball may contain points of its own
};
struct NearPatches {
  NearPatch *patch;
  int32_t patches;
  uint16_t *in, *reached; // (nodes) the sets of centers whose balls contain a node's position, and from which it is reached
  int32_t *node;          // nodes that lie in any ball
  int32_t nodes;
  // (clusters) the sets of centers whose balls contain all of a cluster, or a part of it, and from which it is reached
  uint16_t *whole, *part;
};

// Items with their sets of centers → lists of the items of each center.
struct CenterLists {
  int32_t *item;
  int32_t *centers; // sets of centers
  int32_t count;
  int32_t *of_center[group_lanes]; // each list has room for all items and for sixteen more, as have the two above
};
// Triangles and, for each corner, the set of centers from which it is reached within their balls.
struct TouchedTriangles {
  int32_t *triangle, *corner[3], *turning;
  int32_t count;
};
// Row indices of the moments that count as wholes, and the corners that are alone on their side of the rim. A corner is given by
// the offset of its first float in the array of RimTriangles.
struct GroupLists {
  TouchedTriangles touched;
  CenterLists wholes, corners, turning_corners;
};

// The order of the kernels' Moments: area; xx, xy, yy over r^2; xn, xm + yn, ym over r; facets; noise over r^2.
inline constexpr int ball_sums = 9;
using BallSums = float[ball_sums][group_lanes];

// An edge with both ends outside the balls of some centers.
struct OpenEdge {
  int32_t half_edge, from, to; // from, to: nodes
  uint32_t centers;
};

struct SphereSets {
  uint32_t within, touched;
};

// The functions of one instruction set.
struct BallTarget {
  const char *name;
  // Updates the spheres of one batch, or also its moments and what the rim needs. normals: at the corners of its triangles,
  // (triangles, 3, 3).
  void (*refit_spheres)(const PatchArrays &surface, int32_t batch);
  void (*refit)(const PatchArrays &surface, int32_t batch, const float *normals);
  // Lists the patches near the centers, in their order, and returns their number.
  int32_t (*find)(const PatchArrays &surface, const CenterLanes &centers, NearPatch *patches);
  // Completes the list, and leaves out patches that no ball meets.
  void (*look)(const PatchArrays &surface, const CenterLanes &centers, NearPatches &near);
  // Returns the sets of centers whose balls contain a sphere, and whose balls it may touch.
  SphereSets (*sphere)(const CenterLanes &centers, const float *middle, float reach);
  // Keeps the edges that meet balls with both ends outside, with these centers only, and returns their number.
  int32_t (*dips)(const PatchArrays &surface, const CenterLanes &centers, OpenEdge *edges, int32_t count);
  // Distributes items to the lists of the centers in their sets, and counts the items of each list.
  void (*list)(CenterLists &lists, int32_t centers, int32_t (&counts)[group_lanes]);
  void (*add)(const PatchArrays &surface, const CenterLanes &centers, const NearPatches &near, bool with_noise, GroupLists &lists,
              BallSums &sums);
};
// The instruction sets that this processor has, the widest first.
std::vector<BallTarget> ball_targets();

} // namespace paradesc
