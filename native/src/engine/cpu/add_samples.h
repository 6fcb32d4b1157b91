// Samples of some surfels side by side → sums over the neighborhood of one center, by the widest instructions that the processor
// has.
//
// Sums have the same bits whatever the instructions: sixteen lanes add up by themselves, in the order of the samples, however
// many of them are computed at once, and are added together at the end in one order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace paradesc {

struct EvaluateParams;

inline constexpr int block_lanes = 16;

// What a sample has, a row of block_lanes floats each.
enum SampleRow {
  SAMPLE_X,
  SAMPLE_Y,
  SAMPLE_Z,
  SAMPLE_NORMAL_X,
  SAMPLE_NORMAL_Y,
  SAMPLE_NORMAL_Z,
  SAMPLE_FACE_X, // of the triangles' planes, where SAMPLE_NORMAL is of the normals at their corners
  SAMPLE_FACE_Y,
  SAMPLE_FACE_Z,
  SAMPLE_AREA,
  SAMPLE_PER_SIDE,   // one over the side of a square of that area
  SAMPLE_GRADIENT_X, // of a map, where there is one
  SAMPLE_GRADIENT_Y,
  SAMPLE_GRADIENT_Z,
  SAMPLE_VALUE,
  ALL_ROWS,
  SURFACE_ROWS = SAMPLE_GRADIENT_X
};

// Some blocks of samples: block i begins at data + stride * block[i], its rows one after the other, 64 bytes aligned. Samples
// that fill a block have no area.
struct SampleBlocks {
  const float *data;
  int32_t stride;
  const int32_t *block;
  // (count, filled up to block_lanes with such that reach nothing): the middle of each; the square of the radius around its
  // samples plus that of the neighborhood.
  const float *middle[3];
  const float *limit;
  int32_t count;
};

struct SumCenter {
  float position[3], normal[3];
  float value; // of the map
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
inline constexpr size_t max_sums = 96; // floats

// sums: Moments, BallTerms of half the radius where the kind has them, Terms. Returns the largest share of a sample's distance
// from the center that lies along its normal, squared: 1 where the surface is nearest to the center or farthest from it.
using AddSamples = float (*)(const EvaluateParams &params, const SampleBlocks &samples, const SumCenter &center, float *sums);

// One set of instructions.
struct SumTarget {
  const char *name;
  const AddSamples *by_kind; // (sum_kinds)
};
// Those that this processor has, the widest first.
std::vector<SumTarget> sum_targets();

} // namespace paradesc
