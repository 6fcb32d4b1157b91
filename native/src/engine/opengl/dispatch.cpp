// Tiles follow from how long the last one took.
#include "engine/opengl/dispatch.h"

#include <algorithm>

#include "support/math.h"
#include "support/progress.h"

#include "shared.h"

namespace paradesc {

int next_tile(int tile, double seconds, int smallest, int group) {
  const double scale = std::clamp(0.03 / std::max(seconds, 1e-4), 0.25, 4.0);
  return std::max(smallest, static_cast<int>(std::min(tile * scale, 1e9)) / group * group);
}

// Calls start(first, last) for parts of [0, count), and waits for the device between them.
static void in_tiles(const Gl &gl, int count, int tile, int smallest, int largest, const auto &start) {
  Clock clock;
  for (int first = 0, last = 0; first < count; first = last) {
    last = first + std::min({tile, largest, count - first});
    start(first, last);
    if (last == count) return;
    gl.Finish();
    tile = next_tile(std::min(tile, largest), clock.lap(), smallest, smallest);
  }
}

void dispatch_once(const Gl &gl, int first, int last) {
  gl.Uniform1i(LOCATION_FIRST, first);
  gl.Uniform1i(LOCATION_LAST, last);
  gl.DispatchCompute(group_count(gl, last - first), 1, 1);
}

void dispatch_invocations(const Gl &gl, int count, int64_t first_tile) {
  const int group = gl.limits.group_size, largest = 65535 * group;
  const auto tile = static_cast<int>(std::clamp<int64_t>(first_tile / group * group, group, largest));
  in_tiles(gl, count, tile, group, largest, [&](int first, int last) { dispatch_once(gl, first, last); });
}

void dispatch_texels(const Gl &gl, int size) {
  constexpr int side = 8, first_tile = 1 << 20; // texels
  const int groups = (size + side - 1) / side, rows = std::max(1, first_tile / (size * side));
  in_tiles(gl, groups, rows, 1, groups, [&](int first, int last) {
    gl.Uniform1i(LOCATION_FIRST, first * side);
    gl.DispatchCompute(static_cast<GLuint>(groups), static_cast<GLuint>(last - first), 1);
  });
}

} // namespace paradesc
