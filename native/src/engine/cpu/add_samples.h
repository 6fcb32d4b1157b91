// Samples of the surface → their sums over the neighborhoods of some centers side by side, by the widest instructions that the
// processor has.
//
// Each center is a lane: its sums run over the samples one after the other, whatever the width of the lanes and whichever other
// centers are beside it. So they have the same bits whatever the instructions, and wherever groups of centers begin.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace paradesc {

struct EvaluateParams;

// A Sample of engine/cpu/pieces.h in plain floats.
struct FlatSample {
  float position[3], along[2][3];
  float normal[3], normal_along[2][3];
  float face[3], area, per_area, reach, turn;
  int32_t surfel; // of which it is, or is part
  float map[4];   // gradient and value, where there is a map
};

inline constexpr int max_lanes = 16;

// The last one stands for those that are not there, too.
struct SumCenters {
  float position[3][max_lanes], normal[3][max_lanes];
  float value[max_lanes]; // of the map
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
inline constexpr size_t max_sums = 96;
using Sums = float[max_sums][max_lanes]; // of each: Moments, BallTerms of half the radius where the kind has them, Terms

// shown: for each sample the bits of the centers that it counts for. nearest: those of the centers to which the surface may come
// nearer on it than around it, within the ball.
using AddSamples = void (*)(const EvaluateParams &params, const FlatSample *const *samples, const uint16_t *shown, int32_t count,
                            const SumCenters &centers, Sums &sums, uint16_t *nearest);

// One set of instructions.
struct SumTarget {
  const char *name;
  const AddSamples *by_kind; // (sum_kinds)
};
// Those that this processor has, the widest first.
std::vector<SumTarget> sum_targets();

} // namespace paradesc
