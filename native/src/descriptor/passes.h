// Requested rows → the passes that compute them: descriptors of the surface, then operators that fit the map f (one of these
// descriptors) within the radius, its gradient included, then operators that read f or its gradient in wider windows.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "descriptor/results.h"
#include "paradesc/paradesc.h"
#include "support/math.h"

namespace paradesc {

// The map at every point of the mesh: xyz the gradient (0 in the pass that computes it), w the value.
using MapValues = std::vector<vec4>;

// Descriptors of the surface; the map f, a descriptor; operators that fit f within the radius; operators with wider windows.
enum class Stage { surface, source, map, windows };

struct Pass {
  Stage stage;
  std::vector<int> rows;  // of the registry
  bool makes_map() const; // whether another pass may read its values as a map
};

// Returns at least one pass. map_row gets a pass of its own, with more samples, because operators' derivatives magnify noise.
std::vector<Pass> plan_passes(std::span<const int> requested, int map_row);

// run(pass, map, number, count) evaluates pass number of count at points; map is null if the pass needs none. The values are
// returned in the order of `requested`.
using RunPass = std::function<CenterResults(const Pass &pass, const MapValues *map, int number, int count)>;
CenterResults run_passes(std::span<const int> requested, int map_row, const RunPass &run);

// Samples per neighborhood of a pass. Maps and their derivatives take more, because derivatives magnify noise.
int samples_of(const Pass &pass, const pdesc_options &options);

// The radius of a pass's neighborhoods.
double radius_of(const Pass &pass, const pdesc_options &options, double radius);

// The row of the map's descriptor (NULL: sphere_volume_normalized). Throws Error(INVALID_ARGUMENT) if it cannot be a map.
int find_map(const char *name);

} // namespace paradesc
