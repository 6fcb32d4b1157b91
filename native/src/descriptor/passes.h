// Requested rows → the passes that compute them: descriptors of the surface first, then operators that fit the map f, which is
// one of these, within the radius (its gradient is one), then operators that read f or its gradient in wider windows.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "descriptor/results.h"
#include "paradesc/paradesc.h"
#include "support/math.h"

namespace paradesc {

// The map at every point of the mesh: xyz the gradient (0 in the pass that makes it), w the value.
using MapValues = std::vector<vec4>;

// Descriptors of the surface; the map f, which is one of them; operators that fit f within the radius; those with wider windows.
enum class Stage { surface, source, map, windows };

struct Pass {
  Stage stage;
  std::vector<int> rows;  // of the registry
  bool makes_map() const; // that another pass may read
};

// There is at least one pass. Operators read map_row from a pass of its own, with more samples: derivatives magnify noise.
std::vector<Pass> plan_passes(std::span<const int> requested, int map_row);

// run(pass, map, number, count) evaluates pass number of count; map is null where none is needed. The values come back in the
// order of `requested`.
using RunPass = std::function<CenterResults(const Pass &pass, const MapValues *map, int number, int count)>;
CenterResults run_passes(int point_count, std::span<const int> requested, int map_row, const RunPass &run);

// How many samples a pass takes over each neighborhood: derivatives magnify the noise of what they are taken of, and their own.
int samples_of(const Pass &pass, const pdesc_options &options);

// The radius of the neighborhoods of a pass.
double radius_of(const Pass &pass, const pdesc_options &options, double radius);

// The row of the map's descriptor (NULL: sphere_volume_normalized). Throws Error(INVALID_ARGUMENT) where it cannot be a map.
int find_map(const char *name);

} // namespace paradesc
