// A surface as one pass sums over it → values at centers.
#pragma once

#include <functional>
#include <span>

#include "bake/distortion.h"
#include "descriptor/passes.h"
#include "engine/cpu/finish.h"
#include "engine/cpu/groups.h"
#include "engine/cpu/patch_samples.h"
#include "engine/engine.h"
#include "support/keyed.h"

namespace paradesc {

// The resolution of a surface. A disk of the radius has about `samples` samples. The rim cuts triangles exactly, so these may be
// larger than clusters. They may be much larger for values that do not depend on the last percent of an area, or on the center's
// immediate surroundings.
struct Fineness {
  int samples;
  float triangles = 1.5f; // largest spread of a triangle, relative to that of a cluster
  friend bool operator==(const Fineness &, const Fineness &) = default;
};
Fineness fineness_of(const Pass &pass, const pdesc_options &options);

// The memory of the order of points, for each point, and of patches, their surface and the work of threads.
inline constexpr int64_t bytes_of_order = 100;
constexpr int64_t bytes_of_patches(int64_t triangles, int64_t nodes, int threads) {
  constexpr int64_t of_triangle = 48 + sizeof(RimTriangle) + sizeof(MomentRow) + 10, of_node = 240, of_thread = 12;
  return triangles * of_triangle + nodes * (of_node + threads * of_thread);
}

// The stages of a mesh that are kept from one pass to the next.
struct SummedMesh {
  Keyed<uint64_t, PointOrder> order;                                      // by the topology's version
  Keyed<std::pair<uint64_t, std::vector<int32_t>>, PointPatches> patches; // by that, and the nodes
  PatchSurface surface;                                                   // of the last pass
};

class SummedSurface {
public:
  // All arguments are borrowed. Throws Error if there is too little memory.
  SummedSurface(const PassInputs &of, SummedMesh &kept);

  // map: values at the centers, if there is a map.
  CenterResults at(const CenterPoints &centers, const MapValues &map, std::span<const int> rows,
                   const std::function<void(double)> &progress) const;

private:
  const PassInputs &of_;
  PatchSurface::Mesh mesh_;
  const PointOrder &order_;
  const PointPatches &patches_;
  SampledSurface sampled_;
  SampleLimit limit_;
  EvaluateParams params_;
  PatchSamples samples_;
};

} // namespace paradesc
