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

// What a Sample has, a row of block_lanes floats each.
enum SampleRow {
  SAMPLE_POSITION, // three rows, as of every vector
  SAMPLE_ALONG = SAMPLE_POSITION + 3,
  SAMPLE_NORMAL = SAMPLE_ALONG + 6,
  SAMPLE_NORMAL_ALONG = SAMPLE_NORMAL + 3,
  SAMPLE_FACE = SAMPLE_NORMAL_ALONG + 6,
  SAMPLE_AREA = SAMPLE_FACE + 3,
  SAMPLE_PER_AREA,
  SAMPLE_REACH,
  SAMPLE_TURN,
  SAMPLE_GRADIENT, // of a map, where there is one
  SAMPLE_VALUE = SAMPLE_GRADIENT + 3,
  ALL_ROWS,
  SURFACE_ROWS = SAMPLE_GRADIENT
};

// Some blocks of samples: block i begins at data + stride * block[i], its rows one after the other, 64 bytes aligned. Samples
// that fill a block have no area.
struct SampleBlocks {
  const float *data;
  int32_t stride;
  const int32_t *block;
  const uint16_t *shown; // (count) a bit for each sample that counts
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

// sums: Moments, BallTerms of half the radius where the kind has them, Terms. Returns the number of samples in the ball on which
// the surface may come nearer to the center than around them.
using AddSamples = int32_t (*)(const EvaluateParams &params, const SampleBlocks &samples, const SumCenter &center, float *sums);
// That number among samples [begin, end) of a list alone.
using CountNearest = int32_t (*)(float radius, const float *data, int32_t stride, int32_t begin, int32_t end,
                                 const SumCenter &center);

// One set of instructions.
struct SumTarget {
  const char *name;
  const AddSamples *by_kind; // (sum_kinds)
  CountNearest count_nearest;
};
// Those that this processor has, the widest first.
std::vector<SumTarget> sum_targets();

} // namespace paradesc
