// The size of a tile follows from the time that the last tile took.
#include "engine/paper/dispatch.h"

#include <algorithm>

#include "support/math.h"

#include "shared.h"

namespace paradesc {

int next_tile(int tile, double seconds, int smallest, int group) {
  const double scale = std::clamp(0.03 / std::max(seconds, 1e-4), 0.25, 4.0);
  return std::max(smallest, static_cast<int>(std::min(tile * scale, 1e9)) / group * group);
}

// Returns without waiting for the last tile.
static void dispatch_in_tiles(const Gl &gl, int count, const TileSizes &sizes, const auto &start) {
  in_tiles(
      0, count, sizes,
      [&](int first, int last) {
        start(first, last);
        if (last < count) gl.Finish();
      },
      [](int) {});
}

void dispatch_once(const Gl &gl, int first, int last) {
  gl.Uniform1i(LOCATION_FIRST, first);
  gl.Uniform1i(LOCATION_LAST, last);
  gl.DispatchCompute(group_count(gl, last - first), 1, 1);
}

void dispatch_invocations(const Gl &gl, int count, int64_t first_tile) {
  const int group = gl.limits.group_size, largest = 65535 * group;
  const auto tile = static_cast<int>(std::clamp<int64_t>(first_tile / group * group, group, largest));
  dispatch_in_tiles(gl, count, {tile, group, largest, group}, [&](int first, int last) { dispatch_once(gl, first, last); });
}

void dispatch_texels(const Gl &gl, int size) {
  constexpr int side = 8, first_tile = 1 << 20; // texels
  const int groups = (size + side - 1) / side, rows = std::max(1, first_tile / (size * side));
  dispatch_in_tiles(gl, groups, {rows, 1, groups, 1}, [&](int first, int last) {
    gl.Uniform1i(LOCATION_FIRST, first * side);
    gl.DispatchCompute(static_cast<GLuint>(groups), static_cast<GLuint>(last - first), 1);
  });
}

} // namespace paradesc
