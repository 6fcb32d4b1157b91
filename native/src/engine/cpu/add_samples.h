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
  float normal[3];
  float is_cluster; // 1: of many triangles, whose outline is unknown; 0: of one
  float along[2][3], normal_along[2][3];
  float face[3];
  float noise, facet; // as in a Sample
  float reach;        // of a triangle's corners from its position
  float run_reach;    // at the first sample of each run of a triangle's samples: of all their corners from its position
  float padding;
};
inline constexpr int samples_of_run = 16;

// The map at a sample, for operators: gradient and value. It has the mean and the variation along both directions, like normals.
struct alignas(16) SampleMap {
  float mean[4], along[2][4];
};

inline constexpr int block_lanes = 16; // samples that are processed together

struct SumCenter {
  float position[3], normal[3];
  float value; // of the map
};

// Indices of samples, filled up with zero samples to whole blocks of sixteen.
struct SampleRun {
  const int32_t *item;
  int32_t blocks;
};
// The samples in a center's ball.
struct SelectedSamples {
  const FlatSample *const *sample;
  const SampleMap *const *map; // as many, for kinds that read the map
  SampleRun whole;
  SampleRun cut; // samples that may lie partly within the ball
  bool bending;  // whether sums tell how normals turn towards the center
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
inline constexpr size_t max_sums = 96;

// sums: the Moments, then the Windows if the kind has them, then the Terms.
using AddSamples = void (*)(const EvaluateParams &params, const SelectedSamples &samples, const SumCenter &center, float *sums);

// The functions of one instruction set.
struct SumTarget {
  const char *name;
  const AddSamples *by_kind; // (sum_kinds)
};
// The instruction sets that this processor has, the widest first.
std::vector<SumTarget> sum_targets();

} // namespace paradesc
