// Samples of the surface → the samples in the ball around a center, and their sums, computed with the widest instructions that
// the processor has.
//
// Each lane holds one sample. Samples are processed sixteen at a time whatever the width, and the sixteen partial sums are added
// in one fixed order. So results have the same bits for all instruction sets, whichever samples outside the ball were examined.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace paradesc {

struct EvaluateParams;

// A Sample of engine/cpu/pieces.h in plain floats. Kernels load four consecutive floats at once wherever three belong together.
struct alignas(16) FlatSample {
  float position[3], area;
  float normal[3], turn;
  float along[2][3], normal_along[2][3];
  float face[3], reach;
  float noise, facet; // as in a Sample
  int32_t surfel;     // the surfel that it is, or is part of
};

// The map at a sample, for operators: gradient and value. It has the mean and the variation along both directions, like normals.
struct alignas(16) SampleMap {
  float mean[4], along[2][4];
};

inline constexpr int block_lanes = 16; // samples that are processed together

struct SumCenter {
  float position[3], normal[3];
  float value; // of the map
};

// Samples as structure of arrays: the data that selection reads first, and all that the shape operator needs of samples within
// the ball.
struct alignas(64) SampleBlock {
  float corner[3][3][block_lanes], face[3][block_lanes], turn[block_lanes], reach[block_lanes];
  float normal[3][block_lanes], area[block_lanes], noise[block_lanes], facet[block_lanes];
  float turning[6][block_lanes]; // area times the covariation of normals and positions: xx, yy, zz, xy + yx, xz + zx, yz + zy
};
// Blocks that may contain samples of the ball, and their bounding spheres: centers and radii, padded to whole blocks.
struct Candidates {
  const SampleBlock *const *block;
  const float *sphere[4];
  int32_t count; // number of spheres
};
// A subset of a block's samples, as a bit mask.
struct BlockPart {
  int32_t block;
  uint32_t samples;
};
// The result of a selection among candidates, block by block. The lists have room for all samples.
struct Selection {
  BlockPart *whole; // samples that lie entirely within the ball
  int32_t *cut;     // samples that may lie partly within it
  int32_t *nearest; // samples on which the surface may have a local minimum of the distance to the center, within the ball
  int32_t wholes, cuts, nearests;
};
using SelectSamples = void (*)(const Candidates &candidates, const float *center, float radius, Selection &selection);

// A list of samples, padded with zero samples to whole blocks of sixteen.
struct SampleRun {
  const FlatSample *const *sample;
  const SampleMap *const *map; // (samples) for kinds that read the map
  int32_t blocks;
};
// The samples in a center's ball. The shape operator alone takes those within it as block parts; all other sums take a run.
struct SelectedSamples {
  std::span<const BlockPart> parts; // block parts within the ball
  const SampleBlock *const *block;
  SampleRun whole;
  SampleRun cut; // samples that may lie partly within the ball
};

// The kind of sums. Each has a kernel of its own.
enum class SumKind : int32_t {
  fit,
  surface,
  surface_geodesic,
  extrapolated,
  extrapolated_geodesic,
  jet,
  jet_geodesic,
  windows,
  windows_geodesic
};
inline constexpr int sum_kinds = 9;
constexpr bool adds_blocks(SumKind kind) { return kind == SumKind::fit; } // Tells whether the kind adds block parts.
inline constexpr size_t max_sums = 96;

// sums: the Moments, then the Windows if the kind has them, then the Terms.
using AddSamples = void (*)(const EvaluateParams &params, const SelectedSamples &samples, const SumCenter &center, float *sums);

// Balls of one radius around some centers. Slots behind the last center are far away.
inline constexpr int max_balls = 64;
struct alignas(64) Balls {
  float center[3][max_balls];
  int32_t count;
  float radius;
};
// One bit per ball: whether the sphere of radius `reach` around `middle` lies within the ball, and whether it may touch the ball.
struct BallBits {
  uint64_t within, touched;
};
using FindBalls = BallBits (*)(const Balls &balls, const float *middle, float reach);
// One bit per ball: whether the edge between the two points meets the ball.
using BallsOfEdge = uint64_t (*)(const Balls &balls, const float *from, const float *to);

// The functions of one instruction set.
struct SumTarget {
  const char *name;
  SelectSamples select;
  FindBalls find_balls;
  BallsOfEdge balls_of_edge;
  const AddSamples *by_kind; // (sum_kinds)
};
// The instruction sets that this processor has, the widest first.
std::vector<SumTarget> sum_targets();

} // namespace paradesc
