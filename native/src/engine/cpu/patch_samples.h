// The triangles and clusters of a surface, in the order of its patches → the samples of those that are summed one by one.
#pragma once

#include <vector>

#include "descriptor/passes.h"
#include "engine/cpu/patch_surface.h"
#include "engine/cpu/point_patches.h"
#include "engine/cpu/triangle_samples.h"

namespace paradesc {

// A surface at one time, and the values of a map at its points. All of it is borrowed.
struct SampledSurface {
  const PointPatches &patches;
  const PatchSurface &surface;
  const PatchSurface::Mesh &mesh;
  const MapValues *map; // or null
  int threads;

  SampledTriangle triangle(int32_t place) const; // index in the order of the patches
  Sample cluster(int32_t index) const;
  SampleMap map_of_cluster(int32_t index, const Sample &sample) const;
};

// The triangles that are summed one by one: all, or only those that have no moments since they are large. All clusters are, too.
enum class SampledTriangles { all, large };

// The samples of some patches in a row.
struct SampleBlock {
  std::vector<int32_t> item;     // a triangle in the order of the patches, or ~i: cluster i; those without area are left out
  std::vector<int32_t> begin{0}; // (patches + 1) into item
  std::vector<int32_t> first{0}; // (items + 1) into list; no samples of an item that is divided
  SampleList list;

  // Returns whether each group of centers divides this item's triangle, which is very large.
  bool is_divided(int32_t k) const { return first[k] == first[k + 1]; }
};

inline constexpr int32_t patches_of_block = 64;
using PatchSamples = std::vector<SampleBlock>;

// Calls use(block, k) for each item k of a patch.
template <class Use> void for_each_item(const PatchSamples &samples, int32_t patch, const Use &use) {
  const SampleBlock &block = samples[patch / patches_of_block];
  const int32_t *const begin = block.begin.data() + patch % patches_of_block;
  for (int32_t k = begin[0]; k < begin[1]; ++k) use(block, k);
}

// The memory of a sample in a list.
inline constexpr int64_t bytes_of_sample = sizeof(FlatSample) + 2 * sizeof(int32_t);

// Returns about how many samples the lists will have.
double count_samples(const SampledSurface &surface, const SampleLimit &limit, SampledTriangles which);
PatchSamples list_samples(const SampledSurface &surface, const SampleLimit &limit, SampledTriangles which);

} // namespace paradesc
