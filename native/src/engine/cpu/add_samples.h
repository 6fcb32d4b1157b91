// Samples of the surface → those in the ball around a center, and their sums, by the widest instructions that the processor has.
//
// A lane is a sample: samples are taken sixteen at a time whatever the width, and the sixteen sums are added up in one order. So
// results have the same bits whatever the instructions, and whichever samples outside the ball were looked at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace paradesc {

struct EvaluateParams;

// A Sample of engine/cpu/pieces.h in plain floats. Four are read at a time from wherever three belong together.
struct alignas(16) FlatSample {
  float position[3], area;
  float normal[3], turn;
  float along[2][3], normal_along[2][3];
  float face[3], reach;
  float noise, facet; // as those of a Sample
  int32_t surfel;     // of which it is, or is part
};

// What operators look at: gradient and value, as the normal of a sample: their mean, and how they vary along both directions.
struct alignas(16) SampleMap {
  float mean[4], along[2][4];
};

inline constexpr int block_lanes = 16; // samples that are added together

struct SumCenter {
  float position[3], normal[3];
  float value; // of the map
};

// Samples side by side: what is asked of them before they are read, and all that the shape operator needs of those that lie in
// the ball.
struct alignas(64) SampleBlock {
  float corner[3][3][block_lanes], face[3][block_lanes], turn[block_lanes], reach[block_lanes];
  float normal[3][block_lanes], area[block_lanes], noise[block_lanes], facet[block_lanes];
  float turning[6][block_lanes]; // their area times how normals vary with positions: xx, yy, zz, xy + yx, xz + zx, yz + zy
};
// Blocks in which a ball's samples may be, and the spheres around them: middles and radii, as many as fill whole blocks.
struct Candidates {
  const SampleBlock *const *block;
  const float *sphere[4];
  int32_t count; // of spheres
};
// Some samples of a block, as bits.
struct BlockPart {
  int32_t block;
  uint32_t samples;
};
// Of candidates, block by block, in lists that have room for all.
struct Selection {
  BlockPart *whole; // that lie in the ball
  int32_t *cut;     // that may lie there in part
  int32_t *nearest; // on which the surface may come nearer to the center than around it, within the ball
  int32_t wholes, cuts, nearests;
};
using SelectSamples = void (*)(const Candidates &candidates, const float *center, float radius, Selection &selection);

// Sixteen at a time: what is left of the last ones is filled with samples that are all zero.
struct SampleRun {
  const FlatSample *const *sample;
  const SampleMap *const *map; // of each, for kinds that read it
  int32_t blocks;
};
// What lies in the ball of a center: parts of blocks for the shape operator alone, else a run.
struct SelectedSamples {
  std::span<const BlockPart> parts; // of the blocks
  const SampleBlock *const *block;
  SampleRun whole;
  SampleRun cut; // what may lie there in part
};

// What is added up, compiled for itself.
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
constexpr bool adds_blocks(SumKind kind) { return kind == SumKind::fit; } // as parts of them
inline constexpr size_t max_sums = 96;

// sums: Moments, Windows where the kind has them, Terms.
using AddSamples = void (*)(const EvaluateParams &params, const SelectedSamples &samples, const SumCenter &center, float *sums);

// Balls of one radius around some centers; behind the last, far off.
inline constexpr int max_balls = 64;
struct alignas(64) Balls {
  float center[3][max_balls];
  int32_t count;
  float radius;
};
// A bit for each of them: whether what reaches so far from its middle lies within the ball, or may touch it.
struct BallBits {
  uint64_t within, touched;
};
using FindBalls = BallBits (*)(const Balls &balls, const float *middle, float reach);
// A bit for each of them: whether the edge between these two points meets the ball.
using BallsOfEdge = uint64_t (*)(const Balls &balls, const float *from, const float *to);

// One set of instructions.
struct SumTarget {
  const char *name;
  SelectSamples select;
  FindBalls find_balls;
  BallsOfEdge balls_of_edge;
  const AddSamples *by_kind; // (sum_kinds)
};
// Those that this processor has, the widest first.
std::vector<SumTarget> sum_targets();

} // namespace paradesc
